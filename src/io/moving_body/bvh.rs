//! Motion capture as BVH text: a hierarchy of joints, then a line of channels for each frame.

use super::gltf::slerp;
use crate::Error;
use crate::body::motion::MOST_FRAMES;
use crate::geometry::Vector3;
use nalgebra::UnitQuaternion;

/// Joints of a person with all fingers, ten times over.
const MOST_JOINTS: usize = 2000;
/// All numbers of the motion, which are held as f64.
const MOST_NUMBERS: usize = 1 << 26;
const EXPORT_AGAIN: &str = "Check that it is a BVH file, and export it again.";

#[derive(Clone, Copy, Debug, PartialEq)]
enum Channel {
    /// Along an axis, in the units of the file.
    Position(usize),
    /// About an axis, degrees.
    Rotation(usize),
}

#[derive(Clone, Debug)]
pub struct Joint {
    pub name: String,
    /// Before this joint in the list.
    pub parent: Option<usize>,
    /// From the parent, in the units of the file.
    pub offset: Vector3,
    channels: Vec<Channel>,
    /// Of its channels in the line of a frame.
    first: usize,
}

/// A motion capture: joints, parents before children, ends of limbs included (without a name), and its frames.
#[derive(Clone, Debug)]
pub struct Capture {
    pub joints: Vec<Joint>,
    /// Frames a second.
    pub frame_rate: f64,
    pub frame_count: usize,
    width: usize,
    /// Frame after frame.
    numbers: Vec<f64>,
}

/// A joint in its parent.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    pub translation: Vector3,
    pub rotation: UnitQuaternion<f64>,
}

impl Capture {
    /// Where joint `j` is in its parent at frame `k`, in the units of the file.
    pub fn pose(&self, j: usize, k: usize) -> Pose {
        let joint = &self.joints[j];
        let values = &self.numbers[k * self.width + joint.first..];
        let (mut translation, mut rotation) = (joint.offset, UnitQuaternion::identity());
        let mut moved = [false; 3];
        for (channel, &value) in joint.channels.iter().zip(values) {
            match *channel {
                // A position stands for the offset, it is not added to it.
                Channel::Position(axis) => {
                    translation[axis] = if moved[axis] { translation[axis] + value } else { value };
                    moved[axis] = true;
                }
                // The first in the list is the outermost.
                Channel::Rotation(axis) => {
                    let axis = nalgebra::Unit::new_unchecked(Vector3::ith(axis, 1.0));
                    rotation *= UnitQuaternion::from_axis_angle(&axis, value.to_radians());
                }
            }
        }
        Pose { translation, rotation }
    }

    /// The same between frames, at `frame` counted from 0.
    pub fn pose_at(&self, j: usize, frame: f64) -> Pose {
        let k = (frame.max(0.0) as usize).min(self.frame_count - 1);
        let (a, t) = (self.pose(j, k), frame - k as f64);
        if t <= 0.0 || k + 1 == self.frame_count {
            return a;
        }
        let b = self.pose(j, k + 1);
        Pose { translation: a.translation.lerp(&b.translation, t), rotation: slerp(a.rotation, b.rotation, t) }
    }
}

/// Reads the text of a BVH file.
pub fn read(text: &str) -> Result<Capture, Error> {
    let mut lines =
        text.lines().zip(1u32..).map(|(line, number)| (line.trim(), number)).filter(|(line, _)| !line.is_empty());
    let (joints, width) = hierarchy(&mut lines)?;
    let mut header = |what: &str| -> Result<f64, Error> {
        let (line, number) = lines.next().ok_or_else(|| ended(what))?;
        let value =
            line.get(..what.len()).filter(|start| start.eq_ignore_ascii_case(what)).map(|_| line[what.len()..].trim());
        let value = value.and_then(|v| v.parse().ok()).filter(|v: &f64| v.is_finite());
        value.ok_or_else(|| at(number, format!("\"{what}\" and a number should stand here.")))
    };
    let frames = header("Frames:")?;
    if !(1.0..=MOST_FRAMES as f64).contains(&frames) || frames.fract() != 0.0 {
        let problem = format!("It has {frames} frames; from 1 to {MOST_FRAMES} are possible.");
        return Err(Error::new(problem, "Cut it into shots.").within("Frames"));
    }
    let time = header("Frame Time:")?;
    if !(1e-4..=100.0).contains(&time) {
        return Err(Error::new(format!("A frame lasts {time} s."), EXPORT_AGAIN).within("Frame Time"));
    }
    let frame_count = frames as usize;
    if frame_count * width > MOST_NUMBERS {
        let problem = format!("{frame_count} frames of {width} channels are more than can be held.");
        return Err(Error::new(problem, "Cut it into shots."));
    }
    let mut numbers = Vec::new();
    for k in 0..frame_count {
        let (line, number) = lines.next().ok_or_else(|| ended(&format!("frame {k} of {frame_count}")))?;
        for word in line.split_ascii_whitespace() {
            let value = word.parse().ok().filter(|v: &f64| v.abs() <= 1e9);
            let wrong = || at(number, format!("\"{}\" stands where a number should be.", word.escape_debug()));
            numbers.push(value.ok_or_else(wrong)?);
        }
        if numbers.len() != (k + 1) * width {
            let problem = format!(
                "Frame {k} has {} numbers, there are {width} channels.",
                numbers.len() as i64 - (k * width) as i64
            );
            return Err(at(number, problem));
        }
    }
    // Times are often rounded: 0.008333 s means 120 frames a second.
    let (rate, whole) = (1.0 / time, (1.0 / time).round());
    let frame_rate = if (rate / whole - 1.0).abs() < 1e-3 { whole } else { rate };
    Ok(Capture { joints, frame_rate, frame_count, width, numbers })
}

fn at(line: u32, problem: String) -> Error {
    Error::new(problem, EXPORT_AGAIN).within(format!("line {line}"))
}

fn ended(before: &str) -> Error {
    Error::new(format!("The file ends before {before}."), EXPORT_AGAIN)
}

/// The joints and how many channels they have together.
fn hierarchy<'a>(lines: &mut impl Iterator<Item = (&'a str, u32)>) -> Result<(Vec<Joint>, usize), Error> {
    let mut joints: Vec<Joint> = Vec::new();
    // The joints whose braces are open, outermost first.
    let mut open: Vec<usize> = Vec::new();
    let mut named: Option<usize> = None;
    let mut width = 0;
    for (line, number) in lines {
        let mut words = line.split_ascii_whitespace();
        let keyword = words.next().unwrap_or_default().to_ascii_uppercase();
        match keyword.as_str() {
            "HIERARCHY" => {}
            "MOTION" if open.is_empty() && named.is_none() && !joints.is_empty() => return Ok((joints, width)),
            "ROOT" | "JOINT" | "END" => {
                if named.is_some()
                    || (keyword == "ROOT") != open.is_empty()
                    || (keyword == "ROOT" && !joints.is_empty())
                {
                    return Err(at(number, format!("{keyword} stands where no joint can begin; there is one root.")));
                }
                if joints.len() == MOST_JOINTS {
                    return Err(at(number, format!("There are more than {MOST_JOINTS} joints.")));
                }
                let name = if keyword == "END" { String::new() } else { line[keyword.len()..].trim().to_owned() };
                let joint = Joint {
                    name,
                    parent: open.last().copied(),
                    offset: Vector3::zeros(),
                    channels: Vec::new(),
                    first: width,
                };
                named = Some(joints.len());
                joints.push(joint);
            }
            "{" => {
                open.push(named.take().ok_or_else(|| at(number, "A brace opens without a joint before it.".into()))?)
            }
            "}" => {
                open.pop()
                    .filter(|_| named.is_none())
                    .ok_or_else(|| at(number, "A brace closes that was not opened.".into()))?;
            }
            "OFFSET" | "CHANNELS" => {
                let joint = open.last().filter(|_| named.is_none());
                let joint =
                    &mut joints[*joint.ok_or_else(|| at(number, format!("{keyword} stands outside a joint.")))?];
                if keyword == "OFFSET" {
                    joint.offset = offset(words).ok_or_else(|| at(number, "OFFSET needs three numbers.".into()))?;
                } else {
                    if !joint.channels.is_empty() {
                        return Err(at(number, "The joint has its channels twice.".into()));
                    }
                    joint.first = width;
                    joint.channels = channels(words).ok_or_else(|| at(number, CHANNELS.into()))?;
                    width += joint.channels.len();
                }
            }
            _ => {
                return Err(at(
                    number,
                    format!(
                        "\"{}\" is no word of a hierarchy.",
                        line.chars().take(40).collect::<String>().escape_debug()
                    ),
                ));
            }
        }
    }
    Err(ended("MOTION"))
}

const CHANNELS: &str =
    "CHANNELS needs a count and as many of Xposition, Yposition, Zposition, Xrotation, Yrotation, Zrotation.";

fn offset<'a>(words: impl Iterator<Item = &'a str>) -> Option<Vector3> {
    let numbers: Vec<f64> = words.map(|w| w.parse().ok().filter(|v: &f64| v.abs() <= 1e9)).collect::<Option<_>>()?;
    Some(Vector3::from(<[f64; 3]>::try_from(numbers).ok()?))
}

fn channels<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<Vec<Channel>> {
    let count: usize = words.next()?.parse().ok().filter(|&c| c <= 9)?;
    let channel = |word: &str| {
        let axis = "xyz".find(word.get(..1)?.to_ascii_lowercase().as_str())?;
        match word[1..].to_ascii_lowercase().as_str() {
            "position" => Some(Channel::Position(axis)),
            "rotation" => Some(Channel::Rotation(axis)),
            _ => None,
        }
    };
    let channels: Vec<Channel> = words.map(channel).collect::<Option<_>>()?;
    (channels.len() == count).then_some(channels)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARM: &str = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation\n \
        JOINT Arm\n {\n  OFFSET 1 0 0\n  CHANNELS 3 Zrotation Xrotation Yrotation\n  End Site\n  {\n   OFFSET 2 0 0\n  }\n }\n}\n\
        MOTION\nFrames: 2\nFrame Time: 0.008333\n1 2 3 0 0 0 0 0 0\n1 2 4 90 0 0 0 0 90\n";

    #[test]
    fn channels_are_applied_in_their_order() {
        let capture = read(ARM).unwrap();
        assert_eq!((capture.joints.len(), capture.frame_rate, capture.frame_count), (3, 120.0, 2));
        assert_eq!((capture.joints[1].name.as_str(), capture.joints[2].parent), ("Arm", Some(1)));
        assert_eq!(capture.pose(0, 1).translation, Vector3::new(1.0, 2.0, 4.0));
        assert_eq!(capture.pose(1, 1).translation, Vector3::x());
        let turned = capture.pose(0, 1).rotation * Vector3::x();
        assert!((turned - Vector3::y()).norm() < 1e-12);
        // Z, then X, then Y outermost first: a vector is turned about y before the others.
        let both = ARM.replace("0 0 90", "90 0 90");
        let turned = read(&both).unwrap().pose(1, 1).rotation * Vector3::z();
        assert!((turned - Vector3::y()).norm() < 1e-12, "{turned}");
        let halfway = capture.pose_at(0, 0.5);
        assert!(
            (halfway.translation.z - 3.5).abs() < 1e-12 && (halfway.rotation.angle() - 45f64.to_radians()).abs() < 1e-9
        );
    }

    #[test]
    fn damaged_captures_are_told_so_with_the_line() {
        let problem = |from: &str, to: &str| read(&ARM.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(problem("OFFSET 1 0 0", "OFFSET 1 nan 0").contains("line 8: OFFSET"));
        assert!(problem("CHANNELS 3 Zrotation", "CHANNELS 3 Wrotation").contains("line 9: CHANNELS"));
        assert!(problem("CHANNELS 3", "CHANNELS 2").contains("line 9"));
        assert!(problem("ROOT Hips\n{", "ROOT Hips").contains("line 3"));
        assert!(problem("1 2 4 90", "1 2 4").contains("line 20: Frame 1 has 8 numbers"));
        assert!(problem("1 2 4 90", "1 2 NaN 90").contains("line 20: \"NaN\""));
        assert!(problem("Frames: 2", "Frames: 3").contains("ends before frame 2"));
        assert!(problem("Frames: 2", "Frames: 1e99").contains("frames"));
        assert!(problem("Time: 0.008333", "Time: 0").contains("lasts 0 s"));
        assert!(problem("MOTION", "").contains("line 17"));
        assert!(read("HIERARCHY").unwrap_err().problem().contains("ends before MOTION"));
    }
}
