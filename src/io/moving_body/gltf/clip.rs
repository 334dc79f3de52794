//! One animation of a glTF file: keys, and what lies between them (glTF 2.0, section 3.11 and appendix C).

use super::accessor::{Numbers, Wanted};
use super::document::{Document, EXPORT_AGAIN, named};
use super::nodes::{Local, Nodes, rotation};
use crate::Error;
use crate::geometry::Vector3;
use gltf_json::accessor::Type;
use gltf_json::animation::{Animation, Interpolation, Property};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index, animation};
use nalgebra::{UnitQuaternion, Vector4};

/// Frames a second where the keys do not tell.
const USUAL_RATE: f64 = 24.0;
/// Keys this evenly spaced are taken for frames, in parts of a frame.
const EVEN: f64 = 0.02;
/// Keys more often than this are no frames, per second.
const FASTEST: f64 = 240.0;

pub struct Clip {
    pub channels: Vec<Channel>,
    /// Of the first and the last key, s.
    pub start: f64,
    pub end: f64,
}

pub struct Channel {
    pub node: usize,
    pub property: Property,
    pub interpolation: Interpolation,
    /// Ascending, s.
    pub times: Vec<f64>,
    /// For each key its value, with CUBICSPLINE its tangent before and after as well.
    pub values: Vec<f64>,
    width: usize,
}

impl Clip {
    /// `morphs` is the number of morph targets of each node.
    pub fn of(document: &mut Document, number: usize, nodes: &Nodes, morphs: &[usize]) -> Result<Self, Error> {
        let animation = document.root.animations[number].clone();
        let place = named("animation", number, animation.name.as_ref());
        let channel = |(k, c): (usize, &animation::Channel)| {
            channel(document, &animation, c, nodes, morphs).map_err(|e| e.within(format!("channel {k}")))
        };
        let channels: Vec<Channel> = animation
            .channels
            .iter()
            .enumerate()
            .map(channel)
            .collect::<Result<_, _>>()
            .map_err(|e| e.within(&place))?;
        if channels.is_empty() {
            return Err(
                Error::new("The animation moves nothing.", "Name another animation of the file.").within(&place)
            );
        }
        let start = channels.iter().map(|c| c.times[0]).fold(f64::INFINITY, f64::min);
        let end = channels.iter().map(|c| c.times[c.times.len() - 1]).fold(f64::NEG_INFINITY, f64::max);
        Ok(Self { channels, start, end })
    }

    pub fn channel_count(&self) -> usize {
        self.channels.len()
    }

    /// Frames a second: what the keys are sampled at, if they are evenly spaced.
    pub fn frame_rate(&self) -> f64 {
        let gaps = self.channels.iter().flat_map(|c| c.times.windows(2).map(|w| w[1] - w[0]));
        let least = gaps.fold(f64::INFINITY, f64::min);
        if !least.is_finite() || 1.0 / least > FASTEST {
            return USUAL_RATE;
        }
        // Times are f32, so that the longest stretch tells the rate best.
        let rate = ((self.end - self.start) / least).round() / (self.end - self.start);
        let even = |t: &f64| ((t - self.start) * rate - ((t - self.start) * rate).round()).abs() <= EVEN;
        if !self.channels.iter().flat_map(|c| &c.times).all(even) {
            return USUAL_RATE;
        }
        let whole = rate.round();
        if (rate / whole - 1.0).abs() < 1e-3 { whole } else { rate }
    }

    /// Puts the nodes and morphs to where they are at `time`, s; `weights` are those of each node.
    pub fn pose(&self, time: f64, locals: &mut [Local], weights: &mut [Vec<f64>]) {
        let mut value = Vec::new();
        for channel in &self.channels {
            channel.sample(time, &mut value);
            if channel.property == Property::MorphTargetWeights {
                weights[channel.node].clone_from(&value);
                continue;
            }
            let Local::Parts { translation, rotation: turned, scale } = &mut locals[channel.node] else { continue };
            match channel.property {
                Property::Translation => *translation = Vector3::from_column_slice(&value),
                Property::Scale => *scale = Vector3::from_column_slice(&value),
                // What has no direction keeps the one it had.
                _ => *turned = rotation(&value).unwrap_or(*turned),
            }
        }
    }
}

fn channel(
    document: &mut Document,
    animation: &Animation,
    channel: &animation::Channel,
    nodes: &Nodes,
    morphs: &[usize],
) -> Result<Channel, Error> {
    let wrong = |problem: String| Error::new(problem, EXPORT_AGAIN);
    let node = channel.target.node.value();
    document.get(channel.target.node, "node")?;
    let Checked::Valid(property) = channel.target.path else {
        return Err(wrong("It moves something that is no translation, rotation, scale or weight.".into()));
    };
    if property != Property::MorphTargetWeights && matches!(nodes.locals[node], Local::Matrix(_)) {
        return Err(wrong(format!("It moves {}, which is placed by a matrix.", nodes.place(node))));
    }
    let sampler = animation.samplers.get(channel.sampler.value());
    let sampler =
        sampler.ok_or_else(|| wrong(format!("It names sampler {}, which does not exist.", channel.sampler.value())))?;
    let Checked::Valid(interpolation) = sampler.interpolation else {
        return Err(wrong("Its interpolation is none of LINEAR, STEP and CUBICSPLINE.".into()));
    };
    let times = document.numbers(sampler.input, Type::Scalar, Wanted::Real)?.values;
    if let Some(k) = times.windows(2).position(|w| w[0] >= w[1]) {
        let error =
            wrong(format!("The times of its keys do not ascend: {} s comes before {} s.", times[k], times[k + 1]));
        return Err(error.within(format!("accessor {}, key {}", sampler.input.value(), k + 1)));
    }
    let (shape, width) = match property {
        Property::Translation | Property::Scale => (Type::Vec3, 3),
        Property::Rotation => (Type::Vec4, 4),
        Property::MorphTargetWeights => (Type::Scalar, morphs[node]),
    };
    if width == 0 {
        return Err(wrong(format!("It moves morph targets of {}, which has none.", nodes.place(node))));
    }
    let outputs = document.numbers(sampler.output, shape, Wanted::Real)?;
    let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let expected = times.len().saturating_mul(per_key).saturating_mul(width);
    if outputs.values.len() != expected {
        let error = wrong(format!(
            "It has {} keys and {} values; {} would be right.",
            times.len(),
            outputs.count(),
            expected / outputs.width
        ));
        return Err(error.within(format!("accessor {}", sampler.output.value())));
    }
    if property == Property::Rotation {
        check_rotations(&outputs, per_key, sampler.output)?;
    }
    Ok(Channel { node, property, interpolation, times, values: outputs.values, width })
}

fn check_rotations(outputs: &Numbers, per_key: usize, accessor: Index<Accessor>) -> Result<(), Error> {
    // Of three values of a key the one in the middle is the rotation, the others are tangents.
    let keys = (per_key / 2..outputs.count()).step_by(per_key);
    match keys.into_iter().find(|&k| rotation(outputs.element(k)).is_none()) {
        None => Ok(()),
        Some(k) => {
            let error = Error::new("The quaternion of a key is zero, which is no rotation.", EXPORT_AGAIN);
            Err(error.within(format!("accessor {}, element {k}", accessor.value())))
        }
    }
}

impl Channel {
    fn sample(&self, time: f64, out: &mut Vec<f64>) {
        let after = self.times.partition_point(|&t| t <= time);
        out.clear();
        // Before the first key and after the last the value stands still.
        if after == 0 || after == self.times.len() {
            return out.extend(self.value(after.saturating_sub(1)));
        }
        let before = after - 1;
        let length = self.times[after] - self.times[before];
        let t = (time - self.times[before]) / length;
        let (a, b) = (self.value(before), self.value(after));
        match self.interpolation {
            Interpolation::Step => out.extend(a),
            Interpolation::Linear if self.property == Property::Rotation => {
                if let (Some(a), Some(b)) = (rotation(a), rotation(b)) {
                    out.extend(slerp(a, b, t).coords.iter());
                }
            }
            Interpolation::Linear => out.extend(a.iter().zip(b).map(|(a, b)| a + (b - a) * t)),
            Interpolation::CubicSpline => {
                let (leaving, arriving) = (self.part(before, 2), self.part(after, 0));
                let [h00, h10, h01, h11] = hermite(t);
                let curve = |k: usize| h00 * a[k] + h10 * length * leaving[k] + h01 * b[k] + h11 * length * arriving[k];
                out.extend((0..self.width).map(curve));
            }
        }
    }

    fn value(&self, key: usize) -> &[f64] {
        self.part(key, 1)
    }

    /// Of a key of CUBICSPLINE the tangent before it, its value, the tangent after it; of others the value.
    fn part(&self, key: usize, part: usize) -> &[f64] {
        let at = if self.interpolation == Interpolation::CubicSpline { 3 * key + part } else { key };
        &self.values[at * self.width..][..self.width]
    }
}

/// Weights of value and tangent at the start, then at the end, of a cubic Hermite curve.
fn hermite(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [2.0 * t3 - 3.0 * t2 + 1.0, t3 - 2.0 * t2 + t, 3.0 * t2 - 2.0 * t3, t3 - t2]
}

/// From `a` to `b` at even speed on the shorter arc (Shoemake 1985).
pub fn slerp(a: UnitQuaternion<f64>, b: UnitQuaternion<f64>, t: f64) -> UnitQuaternion<f64> {
    /// Nearer ones are mixed in a straight line: the angle's sine has no digits left there.
    const NEAR: f64 = 1.0 - 1e-9;
    let (p, mut q): (Vector4<f64>, Vector4<f64>) = (a.coords, b.coords);
    let mut cosine = p.dot(&q);
    if cosine < 0.0 {
        (q, cosine) = (-q, -cosine);
    }
    let mixed = if cosine > NEAR {
        p * (1.0 - t) + q * t
    } else {
        let angle = cosine.acos();
        p * ((1.0 - t) * angle).sin() + q * (t * angle).sin()
    };
    UnitQuaternion::new_normalize(mixed.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(degrees: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), degrees.to_radians())
    }

    #[test]
    fn halfway_between_two_rotations_is_half_the_angle_on_the_shorter_arc() {
        let against = |b: UnitQuaternion<f64>, t, expected| slerp(turn(0.0), b, t).angle_to(&turn(expected));
        assert!(against(turn(90.0), 0.5, 45.0) < 1e-9);
        assert!(against(turn(90.0), 0.25, 22.5) < 1e-9);
        // The same rotation with the other sign, and one that is nearer the other way round.
        assert!(against(UnitQuaternion::new_unchecked(-turn(90.0).into_inner()), 0.5, 45.0) < 1e-9);
        assert!(against(turn(270.0), 0.5, -45.0) < 1e-9);
        assert!(against(turn(1e-4), 0.5, 5e-5) < 1e-12);
    }

    fn channel(interpolation: Interpolation, property: Property, values: Vec<f64>, width: usize) -> Channel {
        Channel { node: 0, property, interpolation, times: vec![1.0, 3.0], values, width }
    }

    fn at(channel: &Channel, time: f64) -> Vec<f64> {
        let mut out = Vec::new();
        channel.sample(time, &mut out);
        out
    }

    #[test]
    fn keys_are_met_and_held_outside() {
        let linear = channel(Interpolation::Linear, Property::Translation, vec![0.0, 1.0, 2.0, 4.0, 1.0, 0.0], 3);
        assert_eq!(at(&linear, 0.0), [0.0, 1.0, 2.0]);
        assert_eq!(at(&linear, 1.5), [1.0, 1.0, 1.5]);
        assert_eq!(at(&linear, 9.0), [4.0, 1.0, 0.0]);
        let step = channel(Interpolation::Step, Property::Scale, vec![1.0; 6], 3);
        assert_eq!(at(&step, 2.9), [1.0; 3]);
    }

    #[test]
    fn cubic_splines_are_the_cubic_that_has_their_values_and_tangents() {
        // x³ on [1, 3]: values 1 and 27, slopes 3 and 27; tangents outside are never looked at.
        let cube =
            channel(Interpolation::CubicSpline, Property::MorphTargetWeights, vec![9e9, 1.0, 3.0, 27.0, 27.0, 9e9], 1);
        for time in [1.0f64, 1.7, 2.0, 2.9, 3.0] {
            assert!((at(&cube, time)[0] - time.powi(3)).abs() < 1e-12);
        }
    }

    #[test]
    fn evenly_spaced_keys_tell_the_frame_rate() {
        let clip = |times: &[f32]| {
            let times: Vec<f64> = times.iter().map(|&t| f64::from(t)).collect();
            let (start, end) = (times[0], times[times.len() - 1]);
            let values = vec![0.0; times.len()];
            let (property, interpolation) = (Property::MorphTargetWeights, Interpolation::Linear);
            Clip { channels: vec![Channel { node: 0, property, interpolation, times, values, width: 1 }], start, end }
        };
        let at = |rate: f32, count: u8| clip(&(0..count).map(|k| f32::from(k) / rate).collect::<Vec<_>>()).frame_rate();
        assert_eq!((at(24.0, 72), at(30.0, 9), at(120.0, 200)), (24.0, 30.0, 120.0));
        assert_eq!(clip(&[0.0, 0.1, 0.37, 1.0]).frame_rate(), USUAL_RATE);
        assert_eq!(clip(&[0.5]).frame_rate(), USUAL_RATE);
    }
}
