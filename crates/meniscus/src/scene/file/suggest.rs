//! The known name that a wrong one was probably meant to be.

/// The most similar of `known`, if it is similar at all.
pub(in crate::scene) fn nearest<'a>(
    wrong: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let wrong = wrong.to_lowercase();
    let mut best = (0.7, None);
    for name in known {
        let similarity = strsim::jaro_winkler(&wrong, &name.to_lowercase());
        if similarity > best.0 {
            best = (similarity, Some(name));
        }
    }
    best.1
}

/// "a", "a or b", "a, b or c".
pub(in crate::scene) fn one_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    match names.split_last() {
        None => "nothing".to_owned(),
        Some((only, [])) => (*only).to_owned(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
    }
}

/// What to do about a name that is not known.
pub(in crate::scene) fn help_for(wrong: &str, known: &[&str], what: &str) -> String {
    let list = one_of(known.iter().copied());
    match nearest(wrong, known.iter().copied()) {
        Some(name) => format!("did you mean `{name}`? {what}: {list}"),
        None => format!("{what}: {list}"),
    }
}
