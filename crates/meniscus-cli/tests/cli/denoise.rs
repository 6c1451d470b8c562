//! `--denoise`, in builds with the denoiser and without.

use crate::run::Folder;
use meniscus::film::Film;
use std::path::Path;

/// Red, green and blue of an EXR, pixel by pixel.
fn colors(path: &Path) -> Vec<f32> {
    let image = exr::prelude::read_all_flat_layers_from_file(path).unwrap();
    let channels = &image.layer_data[0].channel_data.list;
    let planes = ["R", "G", "B"].map(|name| {
        let found = channels.iter().find(|channel| channel.name.eq(name));
        let values: Vec<f32> = found.unwrap().sample_data.values_as_f32().collect();
        values
    });
    planes.concat()
}

#[test]
fn denoising_takes_noise_away_or_says_how_to_get_it() {
    let folder = Folder::with_water();
    let picture = "render water.toml --integrator path --size 96x64 --fov 16 --ground \
                   --background sky --set integrator.clamp=4 -q";
    if !Film::CAN_DENOISE {
        eprintln!("skipped: built without the feature `oidn`");
        folder.fails(
            &format!("{picture} -o out.exr --denoise"),
            2,
            &[
                "built without Open Image Denoise",
                "OIDN_DIR",
                "--features oidn",
            ],
        );
        return;
    }
    folder.done(&format!("{picture} -o many.exr --spp 512"));
    folder.done(&format!("{picture} -o noisy.exr --spp 2"));
    folder.done(&format!("{picture} -o clean.exr --spp 2 --denoise"));
    let reference = colors(&folder.path("many.exr"));
    let error = |name: &str| {
        let found = colors(&folder.path(name));
        let differences = found.iter().zip(&reference);
        let squares: f32 = differences.map(|(a, b)| (a - b) * (a - b)).sum();
        (squares / reference.len() as f32).sqrt()
    };
    let [noisy, clean] = [error("noisy.exr"), error("clean.exr")];
    assert!(clean < 0.5 * noisy, "{clean} of {noisy} is left");
    folder.fails(
        &format!("{picture} -o part.exr --spp 4 --samples 0-1 --denoise"),
        2,
        &["--samples makes a part"],
    );
}
