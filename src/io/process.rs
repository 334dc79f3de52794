//! What this process has used of the machine, and which machine it is. `None` where the system does
//! not tell.

use std::fs;

/// Processor seconds of all threads since the process started.
pub fn cpu_seconds() -> Option<f64> {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(unix))]
    None
}

/// The most memory that was resident at once, bytes.
///
/// From `/proc`, since `getrusage` counts what the parent had before the program was started.
pub fn peak_memory_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let kibibytes: u64 = field(&status, "VmHWM")?.strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// The processor as its maker calls it.
pub fn cpu_name() -> Option<String> {
    Some(field(&fs::read_to_string("/proc/cpuinfo").ok()?, "model name")?.to_owned())
}

/// The operating system and the kind of processor, such as `linux x86_64`.
pub fn system_name() -> String {
    format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)
}

/// The value of the first line `key : value`.
fn field<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    text.lines().filter_map(|line| line.split_once(':')).find(|(k, _)| k.trim() == key).map(|(_, value)| value.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found() {
        let text = "Name:\ttoile\nVmHWM:\t    7040 kB\nmodel name\t: A: processor\n";
        assert_eq!(field(text, "VmHWM"), Some("7040 kB"));
        assert_eq!(field(text, "model name"), Some("A: processor"));
        assert_eq!(field(text, "VmRSS"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn work_takes_time_and_memory() {
        let before = cpu_seconds().unwrap();
        let work: Vec<u64> = (0..3_000_000).map(|i: u64| i.wrapping_mul(0x9e37_79b9)).collect();
        assert!(peak_memory_bytes().unwrap() > 8 * work.iter().filter(|w| **w != 1).count() as u64);
        assert!(cpu_seconds().unwrap() > before);
    }
}
