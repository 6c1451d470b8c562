use super::*;

fn names(set: &ChannelSet, style: AovStyle) -> Vec<String> {
    set.planes(style)
        .into_iter()
        .map(|plane| plane.name)
        .collect()
}

#[test]
fn the_default_is_color_and_depth() {
    let none: [&str; 0] = [];
    let set = ChannelSet::new(&none, &[("density".into(), 1)]).unwrap();
    assert_eq!(names(&set, AovStyle::Plain), ["R", "G", "B", "A", "Z"]);
    assert_eq!(set, ChannelSet::default());
}

#[test]
fn all_is_whatever_exists_and_names_never_clash() {
    let attributes = [("velocity".into(), 3), ("id".into(), 1), ("F".into(), 9)];
    let set = ChannelSet::new(&["all"], &attributes).unwrap();
    let plain = names(&set, AovStyle::Plain);
    for name in [
        "P.Y",
        "albedo.B",
        "id",
        "velocity.Z",
        "attribute.id",
        "F.8",
        "samples",
    ] {
        assert!(plain.iter().any(|n| n == name), "{name} in {plain:?}");
    }
    for style in [AovStyle::Plain, AovStyle::Blender] {
        let mut sorted = names(&set, style);
        sorted.sort();
        sorted.dedup();
        assert_eq!(sorted.len(), plain.len());
    }
    assert!(names(&set, AovStyle::Blender).contains(&"ViewLayer.Normal.Z".to_owned()));
    assert_eq!(set.attributes()[2].offset, 4);
}

#[test]
fn what_cannot_be_had_is_an_error() {
    let attributes = [("density".into(), 1)];
    let message = ChannelSet::new(&["velocity"], &attributes)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("velocity") && message.contains("density"),
        "{message}"
    );
}
