//! Denoising of a finished film by Intel's Open Image Denoise, a neural network that looks at base
//! colours and normals beside the noisy light. Only builds with the feature `oidn` have it.

use super::{Film, FilmError, PlaneData};

impl Film {
    /// Whether this build can denoise.
    pub const CAN_DENOISE: bool = cfg!(feature = "oidn");
    /// Channels that [`Film::denoise`] looks at.
    pub const DENOISING_CHANNELS: [&str; 2] = ["denoising_albedo", "denoising_normal"];

    /// Takes the noise out of red, green and blue; coverage and all other channels stay. The film is
    /// finished by it: nothing more may be merged in. Unlike everything else here the result depends,
    /// in its last bits, on the machine and the version of the denoiser.
    ///
    /// # Errors
    /// In builds without denoiser, without [`Film::DENOISING_CHANNELS`], and when the denoiser fails.
    pub fn denoise(&mut self) -> Result<(), FilmError> {
        let [albedo, normal] = Self::DENOISING_CHANNELS.map(|name| self.triples(name));
        let (Some(albedo), Some(normal)) = (albedo, normal) else {
            return Err(FilmError::Denoise {
                message: format!(
                    "the film lacks the channels {}",
                    Self::DENOISING_CHANNELS.join(" and ")
                ),
            });
        };
        let pixels = self.region().pixels() as usize;
        let mut color = Vec::with_capacity(3 * pixels);
        for pixel in 0..pixels {
            color.extend_from_slice(&self.rgba(pixel)[..3]);
        }
        let size = [self.region().width as usize, self.region().height as usize];
        filter(size, &mut color, &albedo, &normal)?;
        for (pixel, rgb) in color.chunks_exact(3).enumerate() {
            self.set_color(pixel, [rgb[0], rgb[1], rgb[2]]);
        }
        Ok(())
    }

    /// A channel of three planes, pixel by pixel.
    fn triples(&self, channel: &str) -> Option<Vec<f32>> {
        let planes = ["X", "Y", "Z"].map(|axis| self.plane_named(&format!("{channel}.{axis}")));
        let [
            Some(PlaneData::F32(x)),
            Some(PlaneData::F32(y)),
            Some(PlaneData::F32(z)),
        ] = planes
        else {
            return None;
        };
        let triples = x.into_iter().zip(y).zip(z);
        Some(triples.flat_map(|((x, y), z)| [x, y, z]).collect())
    }
}

/// Runs the network over `color`, linear light of any brightness.
#[cfg(feature = "oidn")]
fn filter(
    [width, height]: [usize; 2],
    color: &mut [f32],
    albedo: &[f32],
    normal: &[f32],
) -> Result<(), FilmError> {
    let run = || -> Result<Vec<f32>, oidn::Error> {
        let device = oidn::Device::cpu()?;
        let [albedo, normal] = [device.create_buffer(albedo)?, device.create_buffer(normal)?];
        let mut clean = vec![0.0; color.len()];
        let mut network = oidn::RayTracing::try_new(&device)?;
        network.image_dimensions(width, height).hdr(true);
        network
            .albedo_normal_buffer(albedo, normal)?
            .filter(color, &mut clean)?;
        Ok(clean)
    };
    let clean = run().map_err(|error| FilmError::Denoise {
        message: error.to_string(),
    })?;
    color.copy_from_slice(&clean);
    Ok(())
}

#[cfg(not(feature = "oidn"))]
fn filter(_: [usize; 2], _: &mut [f32], _: &[f32], _: &[f32]) -> Result<(), FilmError> {
    Err(FilmError::Denoise {
        message: "this build has no denoiser (feature `oidn`)".to_owned(),
    })
}
