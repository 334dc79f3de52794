//! What can be asked for on the command line.

use super::Failure;
use crate::io::{dxf, length, settings_toml};
use crate::pattern::Fabric;
use crate::prepositioning::{FinishLine, Settings, resting_clearance};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// From a sewing pattern and a body to the garment already sewn and resting on the body.
#[derive(Parser, Debug)]
#[command(name = "toile", version, max_term_width = 100, after_help = EXIT_STATUS)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_STATUS: &str = "\
Exit status: 0 fine, 1 our fault, 2 usage, 3 invalid input, 4 solved but a quality gate failed, \
5 evaluations used up before the equilibrium, 130 interrupted. With 4 and 5 all results are written.";

#[derive(Subcommand, Debug)]
pub enum Command {
    /// Fit an embedded pattern to the embedded body, in seconds, pictures and all
    Demo(Demo),
    /// Sew a pattern around a body and let it come to rest
    Fit(Fit),
    /// Race the levels against one resolution alone, by several minimizers, to the same finish line
    Compare(Compare),
    /// Tell everything that is wrong or doubtful with the input, before any solving
    Check(Check),
    /// Write a fitted garment, at rest or in motion, as files that other programs take
    Export(Export),
    /// Move fitted garments along with a moving body, by explicit dynamics from where the fit ended
    Simulate(Simulate),
    /// Tell what is recognized in a body: unit, position, landmarks and girths
    Body(Body),
    /// Write a pattern of any kind in the format of toile, which holds all of it
    Convert(Convert),
    /// Propose seams, draw them, or tell how much longer one side is than the other
    #[command(subcommand)]
    Seams(super::seams::Seams),
    /// Place the panels of a pattern around a body, and write where, ready to be changed
    Place(Place),
}

/// How to read what a drawing leaves open.
#[derive(Args, Debug)]
pub struct Reading {
    /// Unit of a DXF drawing: mm, cm, in or m [default: guessed from the size of the panels]
    #[arg(long, value_name = "UNIT")]
    pub unit: Option<String>,
    /// Size to be read of a graded DXF file [default: its sample size]
    #[arg(long, value_name = "SIZE", allow_hyphen_values = true)]
    pub size: Option<String>,
}

impl Reading {
    pub fn options(&self) -> Result<dxf::Options, Failure> {
        let unit = self.unit.as_deref().map(length::Unit::named).transpose();
        let unit = unit.map_err(|e| Failure::Usage(e.within("--unit")))?;
        Ok(dxf::Options { unit, size: self.size.clone() })
    }
}

#[derive(Args, Debug)]
pub struct Convert {
    /// Sewing pattern: GarmentCode, DXF (AAMA, ASTM), FreeSewing, or toile's own
    pub pattern: PathBuf,
    /// File to write, .toml or .json
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
}

/// Where panels start.
#[derive(Args, Debug, Default)]
pub struct Placing {
    /// Where panels start: as the pattern has them, or placed by themselves [default: by themselves where the pattern
    /// does not place all]
    #[arg(long, value_enum, value_name = "HOW")]
    pub place: Option<PlaceBy>,
    /// Arrangement file (TOML): where single panels are to start; all others are placed by themselves
    #[arg(long, value_name = "FILE")]
    pub arrangement: Option<PathBuf>,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaceBy {
    /// By seams, names and the landmarks of the body
    Auto,
    /// As the pattern has it
    Pattern,
}

#[derive(Args, Debug)]
pub struct Place {
    /// Sewing pattern; its own placement is left aside
    pub pattern: PathBuf,
    /// Seams to sew instead of the pattern's own, a TOML file such as `toile seams suggest` writes
    #[arg(long, value_name = "FILE")]
    pub seams: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// Closed triangle mesh of the body, an OBJ file in metres, y up, facing +z
    #[arg(long, value_name = "OBJ")]
    pub body: PathBuf,
    /// Bring the body into the frame of patterns first
    #[arg(long, value_enum, default_value_t = Align::None)]
    pub align: Align,
    /// Arrangement file to write (TOML)
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Picture of the panels around the body before anything is sewn, to write (PNG)
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
    /// Arrangement file (TOML) to begin with: what it asks for is kept
    #[arg(long, value_name = "FILE")]
    pub arrangement: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct Demo {
    /// Folder for the results
    #[arg(long, value_name = "DIR", default_value = "toile-demo")]
    pub out: PathBuf,
    /// What to fit
    #[arg(long, value_enum, default_value_t = Garment::Tee)]
    pub garment: Garment,
    #[command(flatten)]
    pub solving: Solving,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
pub enum Garment {
    Tee,
    Dress,
}

#[derive(Args, Debug)]
pub struct Fit {
    /// Sewing patterns: GarmentCode, or toile's own; several are worn one over the other, the innermost first
    #[arg(required = true, value_name = "PATTERN")]
    pub patterns: Vec<PathBuf>,
    /// Seams to sew instead of the pattern's own, a TOML file such as `toile seams suggest` writes; of several patterns
    /// one for each, in their order
    #[arg(long, value_name = "FILE")]
    pub seams: Vec<PathBuf>,
    /// Closed triangle mesh of the body, an OBJ file in metres, y up, facing +z
    #[arg(long, value_name = "OBJ")]
    pub body: PathBuf,
    /// Recognize the body's unit, up axis, facing and place, and bring it into metres, y up, facing +z, over the origin
    #[arg(long, value_enum, default_value_t = Align::None)]
    pub align: Align,
    /// Garment that the body wears already: the folder of an earlier fit, or its state.toile; may be given several
    /// times, the innermost first
    #[arg(long, value_name = "DIR")]
    pub over: Vec<PathBuf>,
    /// Folder for the results, made if it is not there; of several garments each has a folder in it
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub placing: Placing,
    #[command(flatten)]
    pub solving: Solving,
}

#[derive(Args, Debug)]
pub struct Compare {
    /// Sewing pattern: GarmentCode, or toile's own
    #[arg(required_unless_present = "replot")]
    pub pattern: Option<PathBuf>,
    /// Seams to sew instead of the pattern's own, a TOML file such as `toile seams suggest` writes
    #[arg(long, value_name = "FILE")]
    pub seams: Option<PathBuf>,
    /// Closed triangle mesh of the body, an OBJ file in metres, y up, facing +z
    #[arg(long, value_name = "OBJ", required_unless_present = "replot")]
    pub body: Option<PathBuf>,
    /// Recognize the body's unit, up axis, facing and place, and bring it into metres, y up, facing +z, over the origin
    #[arg(long, value_enum, default_value_t = Align::None)]
    pub align: Align,
    /// Folder for table, curves and pictures, made if it is not there
    #[arg(long, value_name = "DIR", required_unless_present = "replot")]
    pub out: Option<PathBuf>,
    /// Compare how long the explicit simulator takes to come to rest: from the panels as they are placed, from a fit on
    /// one level, and from a fit on all
    #[arg(long, conflicts_with = "replot")]
    pub dynamics: bool,
    /// Draw table and pictures of an earlier comparison again, from the comparison.json in this folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["pattern", "body"])]
    pub replot: Option<PathBuf>,
    /// Minimizers that go through all levels, such as "conjugate-gradient,lbfgs" [default: that of the settings]
    #[arg(long, value_name = "LIST")]
    pub minimizer: Option<String>,
    /// Minimizers that have the finest level alone, or none
    #[arg(long, value_name = "LIST", default_value = "conjugate-gradient,lbfgs,argmin-lbfgs,dynamic-relaxation")]
    pub rivals: String,
    /// Evaluations on the finest level after which a rival is given up, and a schedule on its way to equilibrium
    #[arg(long, value_name = "EVALUATIONS", default_value_t = 20_000)]
    pub cap: usize,
    /// How much higher than the schedule leaves it a settled garment may hang on average
    #[arg(long, value_name = "LENGTH", default_value = "0.5 mm", allow_hyphen_values = true)]
    pub allowance: String,
    /// Residual of the equilibrium, rms in particle weights [default: 0.1]
    #[arg(long, value_name = "WEIGHTS", allow_hyphen_values = true)]
    pub residual: Option<f64>,
    /// Start a little off, the same way in all runs, by random waves of this seed
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// How far off at most, with --seed
    #[arg(long, value_name = "LENGTH", default_value = "1 mm", allow_hyphen_values = true, requires = "seed")]
    pub perturb: String,
    /// Rivals go on to the cap after they have settled, for whole curves
    #[arg(long)]
    pub whole: bool,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub solving: Solving,
}

#[derive(Args, Debug)]
pub struct Check {
    /// Sewing pattern: GarmentCode, DXF (AAMA, ASTM), FreeSewing, or toile's own
    pub pattern: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
    /// Seams to sew instead of the pattern's own, a TOML file such as `toile seams suggest` writes
    #[arg(long, value_name = "FILE")]
    pub seams: Option<PathBuf>,
    /// Closed triangle mesh of the body, an OBJ file in metres, y up, facing +z
    #[arg(long, value_name = "OBJ")]
    pub body: Option<PathBuf>,
    /// Recognize the body's unit, up axis, facing and place, and bring it into metres, y up, facing +z, over the origin
    #[arg(long, value_enum, default_value_t = Align::None)]
    pub align: Align,
    /// Resolution at which the pattern will be fitted [default: "10 mm"]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, conflicts_with = "levels")]
    pub resolution: Option<String>,
    /// Resolutions of all levels, coarsest first, such as "40,20,10,5 mm"
    #[arg(long, value_name = "LENGTHS", allow_hyphen_values = true)]
    pub levels: Option<String>,
    /// Name of the fabric that the garment will be fitted with, or path of a fabric file (TOML) [default: neutral]
    #[arg(long, value_name = "NAME|FILE")]
    pub fabric: Option<String>,
    /// Distance to be kept from the body [default: half the thickness of the fabric, and "0.25 mm" at least]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    pub clearance: Option<String>,
    /// Write one JSON document instead of words
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub placing: Placing,
}

#[derive(Args, Debug)]
pub struct Export {
    /// Fitted garment: the folder of a fit, or its state.toile
    #[arg(value_name = "FIT")]
    pub fit: PathBuf,
    /// What for, one or several with commas between: blender, usd, newton, contourcraft, npz, ply, pc2, mdd, glb,
    /// glb-skinned, obj
    #[arg(long, value_name = "TARGETS", required = true, value_delimiter = ',')]
    pub to: Vec<String>,
    /// Folder for the files, made if it is not there
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// How the garment moves [default: motion.toile in the folder of the fit, if it is there]
    #[arg(long, value_name = "FILE")]
    pub motion: Option<PathBuf>,
    /// Which frames of the motion, counted from 0, both ends included, and every how manieth: "0..71", "24..", "0..71/2"
    #[arg(long, value_name = "RANGE")]
    pub frames: Option<String>,
    /// The garment as it was fitted, even where a motion is there
    #[arg(long, conflicts_with_all = ["motion", "frames"])]
    pub still: bool,
    /// Animated body, a glTF file, whose joints the garment of glb-skinned follows
    #[arg(long, value_name = "BODY")]
    pub skin: Option<PathBuf>,
    /// Clip of that file in whose pose the garment is, by name or number [default: the first]
    #[arg(long, value_name = "NAME", requires = "skin")]
    pub clip: Option<String>,
    /// Frames a second at which that clip is counted [default: those of the file, else 24]
    #[arg(long, value_name = "RATE", requires = "skin")]
    pub fps: Option<f64>,
    /// Frame of that clip in whose pose the garment is, counted from 0
    #[arg(long, value_name = "N", default_value_t = 0, requires = "skin")]
    pub skin_frame: usize,
}

/// How to solve; what is not given is taken from the settings file, or else has its default.
#[derive(Args, Debug)]
pub struct Solving {
    /// Distance between particles on the finest level, such as "5 mm" [default: "10 mm"]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, conflicts_with = "levels")]
    pub resolution: Option<String>,
    /// Resolutions of all levels, coarsest first, such as "40,20,10,5 mm"
    #[arg(long, value_name = "LENGTHS", allow_hyphen_values = true)]
    pub levels: Option<String>,
    /// Name of a fabric, or path of a fabric file (TOML); for several garments one for all or a list [default: neutral]
    #[arg(long, value_name = "NAME|FILE")]
    pub fabric: Option<String>,
    /// Distance to be kept from the body [default: half the thickness of the fabric, and "0.25 mm" at least]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    pub clearance: Option<String>,
    /// Threads to use; the result is the same for any number [default: one per processor]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// When to stop: handoff or equilibrium [default: handoff]
    #[arg(long, value_name = "LINE")]
    pub until: Option<String>,
    /// Settings that differ from the defaults (TOML)
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// What to tell on the way, on the standard error stream
    #[arg(long, value_enum, default_value_t = Progress::Auto)]
    pub progress: Progress,
}

#[derive(Args, Debug)]
pub struct Simulate {
    /// Folders of fits, or their state.toile; several are worn one over the other, the innermost first
    #[arg(required = true, value_name = "FIT")]
    pub fits: Vec<PathBuf>,
    /// Body that moves: a glTF file with a skin, a folder or pattern of OBJ files, or an OBJ that stands still or that
    /// --motion moves
    #[arg(long, value_name = "BODY")]
    pub body: PathBuf,
    /// Motion of the body: a PC2 or MDD cache of an OBJ, or a BVH motion capture for a glTF
    #[arg(long, value_name = "FILE")]
    pub motion: Option<PathBuf>,
    /// Clip of a glTF file, by name or number [default: the first]
    #[arg(long, value_name = "NAME")]
    pub clip: Option<String>,
    /// Frames a second at which the motion is sampled [default: those of the file, else 24]
    #[arg(long, value_name = "RATE")]
    pub fps: Option<f64>,
    /// Frames to simulate [default: all of the motion; a body that stands still has two seconds]
    #[arg(long, value_name = "N")]
    pub frames: Option<usize>,
    /// The body that the garment was fitted on, where the motion begins in another pose: it moves from the one to the
    /// other first
    #[arg(long, value_name = "OBJ")]
    pub from: Option<PathBuf>,
    /// How long that takes, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, requires = "from")]
    pub transition: f64,
    /// Folder for the results, made if it is not there; of several garments each has a folder in it
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Go on from the checkpoint in the folder of the results
    #[arg(long)]
    pub resume: bool,
    /// symplectic-euler, midpoint, runge-kutta-4, runge-kutta-fehlberg or implicit
    #[arg(long, value_name = "NAME", default_value = "symplectic-euler")]
    pub integrator: String,
    /// How the nearest skin is looked for: tree, aligned-boxes, oriented-boxes, spheres, or, of a body that stands still, maps
    #[arg(long, value_name = "NAME", default_value = "tree")]
    pub broad_phase: String,
    /// Velocity of the wind, metres a second
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", allow_hyphen_values = true)]
    pub wind: String,
    /// Rate at which all motion dies away, 1/s
    #[arg(long, value_name = "RATE")]
    pub drag: Option<f64>,
    /// Damping of the fastest vibrations, 0 to 1
    #[arg(long, value_name = "SHARE")]
    pub damping: Option<f64>,
    /// Speed that cloth keeps when it hits the body, 0 to 1
    #[arg(long, value_name = "SHARE")]
    pub restitution: Option<f64>,
    /// Time that the cloth has to find its balance before the body moves, s [default: 0.1]
    #[arg(long, value_name = "SECONDS")]
    pub settle: Option<f64>,
    /// Stretch beyond which edges do not lengthen, per cent, or "none": stiffness alone holds the cloth [default: 3 more
    /// than the fabric bears]
    #[arg(long, value_name = "PERCENT")]
    pub stretch_limit: Option<String>,
    /// Cloth may pass through cloth
    #[arg(long)]
    pub no_self_collision: bool,
    /// What the panels of a name run into: none, body, others (body and other panels) or all; a * in the name stands for
    /// anything, such as "pocket*=none". May be given several times, of which the last that fits counts
    #[arg(long, value_name = "PANEL=LEVEL")]
    pub collide: Vec<String>,
    /// What keeps a garment up that hangs from its waist, as skirts and trousers do
    #[arg(long, value_enum, default_value_t = Waist::Held)]
    pub waist: Waist,
    /// Height of the floor, such as "0 mm"; "body" for the lowest point of the body in its motion; or "none" [default:
    /// body, if it stands at y = 0]
    #[arg(long, value_name = "HEIGHT", allow_hyphen_values = true)]
    pub floor: Option<String>,
    /// Measure penetration and crossings at the end of every N-th frame; 0 for never
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub measure_every: usize,
    /// Draw every N-th frame; 0 for no pictures [default: so that there are 36 at most]
    #[arg(long, value_name = "N")]
    pub draw_every: Option<usize>,
    /// Threads to work with; changes the time, never the result [default: one for each processor]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// What to tell on the way, on the standard error stream
    #[arg(long, value_enum, default_value_t = Progress::Auto)]
    pub progress: Progress,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waist {
    /// Its waist line goes along with the body and does not sink
    Held,
    /// Friction alone
    Free,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// By what is recognized in the body
    Auto,
    /// The body is taken as it is
    None,
}

#[derive(Args, Debug)]
pub struct Body {
    /// Closed triangle mesh of a person, an OBJ file in any unit and position
    pub body: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Draw the body with its landmarks and sections
    #[arg(long, value_name = "PNG")]
    pub picture: Option<PathBuf>,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// A bar on a terminal, otherwise a line for each level
    Auto,
    /// A JSON object on each line
    Json,
    /// Nothing
    None,
}

/// Resolution where none is asked for, m.
const DEFAULT_RESOLUTION: f64 = 0.01;
/// More threads than any machine of today has processors.
const MOST_THREADS: usize = 1024;

impl Solving {
    /// The settings asked for: defaults, then the settings file, then the options. `file` is the settings file's text,
    /// `fabric` that of the innermost garment.
    pub fn settings(&self, file: Option<&str>, fabric: &Fabric) -> Result<Settings, Failure> {
        let usage = |option: &'static str| move |e: crate::Error| Failure::Usage(e.within(option));
        let mut settings = Settings::for_resolution(DEFAULT_RESOLUTION);
        let named = || self.settings.as_deref().map_or_else(String::new, |path| path.display().to_string());
        if let Some(text) = file {
            // A first reading tells the levels, on which the defaults of all else depend.
            settings_toml::apply(text, &mut settings).map_err(|e| e.within(named()))?;
        }
        if let Some(resolution) = &self.resolution {
            let resolution = length::parse(resolution).map_err(usage("--resolution"))?;
            settings.resolutions = Settings::for_resolution(resolution).resolutions;
        }
        if let Some(levels) = &self.levels {
            settings.resolutions = length::parse_list(levels).map_err(usage("--levels"))?;
        }
        let resolutions = settings.resolutions.clone();
        crate::garment::check_resolutions(&resolutions).map_err(|e| match (&self.levels, &self.resolution) {
            (Some(_), _) => Failure::Usage(e.within("--levels")),
            (None, Some(_)) => Failure::Usage(e.within("--resolution")),
            (None, None) => Failure::Input(e.within("levels").within(named())),
        })?;
        settings = Settings::for_resolution(*resolutions.last().expect("checked: there is a level"));
        settings.clearance = resting_clearance(fabric);
        if let Some(text) = file {
            settings_toml::apply(text, &mut settings).map_err(|e| e.within(named()))?;
        }
        settings.resolutions = resolutions;
        if let Some(clearance) = &self.clearance {
            settings.clearance = length::parse_or_zero(clearance).map_err(usage("--clearance"))?;
        }
        if let Some(until) = &self.until {
            settings.until = settings_toml::finish_line(until).map_err(usage("--until"))?;
        }
        settings.check().map_err(|e| match &self.clearance {
            Some(_) => Failure::Usage(e.within("--clearance")),
            None => Failure::Input(e.within(named())),
        })?;
        Ok(settings)
    }

    /// Threads to work with; `None` for one per processor.
    pub fn threads(&self) -> Result<Option<usize>, Failure> {
        threads(self.threads)
    }
}

/// So many threads as were asked for, if there can be so many.
pub fn threads(asked: Option<usize>) -> Result<Option<usize>, Failure> {
    match asked {
        Some(n) if n == 0 || n > MOST_THREADS => Err(Failure::Usage(
            crate::Error::new(
                format!("{n} threads cannot be used."),
                format!("Give a number from 1 to {MOST_THREADS}, or leave the option out."),
            )
            .within("--threads"),
        )),
        threads => Ok(threads),
    }
}

impl Check {
    /// The resolutions at which the pattern is tried, m, coarsest first.
    pub fn resolutions(&self) -> Result<Vec<f64>, Failure> {
        let (option, resolutions) = match (&self.levels, &self.resolution) {
            (Some(levels), _) => ("--levels", length::parse_list(levels)),
            (None, Some(finest)) => {
                ("--resolution", length::parse(finest).map(|r| Settings::for_resolution(r).resolutions))
            }
            (None, None) => ("--resolution", Ok(Settings::for_resolution(DEFAULT_RESOLUTION).resolutions)),
        };
        let checked = resolutions.and_then(|r| crate::garment::check_resolutions(&r).map(|()| r));
        checked.map_err(|e| Failure::Usage(e.within(option)))
    }

    /// The distance to be kept from the body by a garment of a fabric, m.
    pub fn clearance(&self, fabric: &Fabric) -> Result<f64, Failure> {
        let asked = self.clearance.as_deref().map(length::parse_or_zero).transpose();
        let settings = |clearance| Settings { clearance, ..Settings::default() };
        let checked = asked.and_then(|asked| {
            let clearance = asked.unwrap_or_else(|| resting_clearance(fabric));
            settings(clearance).check().map(|()| clearance)
        });
        checked.map_err(|e| Failure::Usage(e.within("--clearance")))
    }
}

/// Is the run to go on to the equilibrium?
pub fn wants_equilibrium(settings: &Settings) -> bool {
    settings.until == FinishLine::Equilibrium
}
