//! All crossings of rays with one field.

use crate::batch::HitRecord;
use crate::error::GpuError;
use crate::program::Question;
use crate::tracer::{FieldTracer, HIT, IN_DOUBT, NO_ROOM, TraceWork};
use crate::uploaded::{CAPACITIES, Sent, Uploaded};
use meniscus::frame::Blobs;
use meniscus::intersect::{Crossing, Scratch};
use meniscus::math::ray::{Ray, Side};

impl FieldTracer<'_> {
    /// Every crossing of object-space rays with the field of `blobs`, which is the one that was uploaded,
    /// in order, appended to the ray's entry of `crossings`.
    ///
    /// # Errors
    /// Where the device fails; then nothing is appended.
    ///
    /// # Panics
    /// If `crossings` is not as long as `rays`.
    pub fn crossings_many(
        &self,
        blobs: &Blobs,
        rays: &[Ray],
        crossings: &mut [Vec<Crossing>],
        scratch: &mut Scratch,
    ) -> Result<TraceWork, GpuError> {
        assert_eq!(rays.len(), crossings.len(), "one list per ray");
        let mut work = TraceWork {
            rays: rays.len() as u64,
            ..TraceWork::default()
        };
        let Some(uploaded) = self.uploaded() else {
            return Ok(work);
        };
        let mut found: Vec<Vec<Crossing>> = vec![Vec::new(); rays.len()];
        // What is left of each ray.
        let mut rest = rays.to_vec();
        let mut in_doubt: Vec<usize> = Vec::new();
        let mut crowded: Vec<usize> = (0..rays.len()).collect();
        for room in 0..CAPACITIES.len() {
            let mut going = std::mem::take(&mut crowded);
            while !going.is_empty() {
                let sent: Vec<Sent> = (going.drain(..))
                    .filter_map(|index| clipped(uploaded, &rest[index], index))
                    .collect();
                work.device_secs += uploaded.send(
                    self.device(),
                    Question::All,
                    room,
                    &rest,
                    &sent,
                    |sent, records| {
                        let hits = records.iter().take_while(|record| record[0] == HIT);
                        let ray = &rest[sent.index];
                        found[sent.index].extend(hits.map(|hit| crossing_of(ray, sent, hit)));
                        let end = records.iter().find(|record| record[0] != HIT);
                        match end.map(|record| record[0]) {
                            None => going.push(sent.index),
                            Some(IN_DOUBT) => in_doubt.push(sent.index),
                            Some(NO_ROOM) => crowded.push(sent.index),
                            Some(_) => {}
                        }
                    },
                )?;
                for &index in &going {
                    rest[index] = behind(&rest[index], found[index].last());
                }
            }
            if room == 0 {
                work.crowded = crowded.len() as u64;
            }
            for &index in &crowded {
                rest[index] = behind(&rest[index], found[index].last());
            }
        }
        in_doubt.append(&mut crowded);
        work.on_cpu = in_doubt.len() as u64;
        for index in in_doubt {
            found[index].clear();
            blobs.crossings(&rays[index], scratch, &mut found[index]);
        }
        for (list, found) in crossings.iter_mut().zip(&mut found) {
            list.append(found);
        }
        Ok(work)
    }
}

fn clipped(uploaded: &Uploaded, ray: &Ray, index: usize) -> Option<Sent> {
    let clipped = ray.is_traceable().then(|| uploaded.clip(ray)).flatten()?;
    Some(Sent { index, clipped })
}

fn crossing_of(ray: &Ray, sent: &Sent, record: &HitRecord) -> Crossing {
    let number = |i: usize| f64::from(f32::from_bits(record[i]));
    Crossing {
        t: sent.clipped.parameter(ray, number(1) + number(2)),
        entering: record[7] != 0,
    }
}

/// The ray from its last crossing on, as one that leaves a surface.
fn behind(ray: &Ray, last: Option<&Crossing>) -> Ray {
    let Some(last) = last else {
        return *ray;
    };
    let side = match last.entering {
        true => Side::Inside,
        false => Side::Outside,
    };
    ray.with_range(last.t, ray.t_max).with_side(side)
}
