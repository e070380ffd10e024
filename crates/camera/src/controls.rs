//! Locks exposure, gain and white balance, and reads them back.
//!
//! Automatic exposure and white balance change the image of an unchanged gel, which looks like touch. An automatic
//! control is switched off before its value is set. Drivers clamp values without an error, so every value is read back:
//! a control that the camera lacks, or a value that it does not accept, is reported in a sentence.

use std::io;

use fingervision_touch::CaptureSection;

use crate::Device;

/// Numbers of controls in V4L2.
pub(crate) mod id {
    pub(crate) const EXPOSURE_AUTO: u32 = 0x009a_0901;
    pub(crate) const EXPOSURE: u32 = 0x009a_0902;
    pub(crate) const EXPOSURE_CHANGES_RATE: u32 = 0x009a_0903;
    pub(crate) const GAIN_AUTO: u32 = 0x0098_0912;
    pub(crate) const GAIN: u32 = 0x0098_0913;
    pub(crate) const WHITE_BALANCE_AUTO: u32 = 0x0098_090c;
    pub(crate) const WHITE_BALANCE: u32 = 0x0098_091a;
}

/// Manual exposure in the menu of automatic exposure; in the other two menus 0 is off.
const MANUAL: i64 = 1;
/// The unit of exposure in V4L2, s.
const EXPOSURE_UNIT_S: f64 = 1e-4;

/// A value to lock, and the automatic controls that must be off for it.
struct Lock {
    name: &'static str,
    unit: &'static str,
    /// The size of one step, in the unit.
    scale: f64,
    id: u32,
    value: i64,
    automatics: &'static [(u32, i64)],
}

/// Sets the values that `[capture]` gives. Returns a sentence for each value that the camera then does not use.
///
/// # Errors
///
/// The system's, if the list of controls cannot be read.
pub(crate) fn lock(device: &mut dyn Device, capture: &CaptureSection) -> io::Result<Vec<String>> {
    let locks = locks(capture);
    if locks.is_empty() {
        return Ok(Vec::new());
    }
    let controls = device.controls()?;
    let range = |id| controls.iter().find(|control| control.id == id).map(|control| (control.least, control.most));
    let mut differences = Vec::new();
    for lock in &locks {
        let Some((least, most)) = range(lock.id) else {
            differences.push(format!("{} cannot be set: the camera has no such control", lock.name));
            continue;
        };
        for &(automatic, off) in lock.automatics {
            if range(automatic).is_some() {
                differences.extend(
                    set(device, automatic, off).map(|why| format!("automatic {} is not off: {why}", lock.name)),
                );
            }
        }
        if let Some(why) = set(device, lock.id, lock.value) {
            let amount = |steps: i64| lock.amount(steps);
            differences.push(format!(
                "{} is not {}: {why}; the camera takes {} to {}",
                lock.name,
                amount(lock.value),
                amount(least),
                amount(most)
            ));
        }
    }
    Ok(differences)
}

impl Lock {
    /// A value with its unit.
    fn amount(&self, steps: i64) -> String {
        let value = (steps as f64 * self.scale * 1e6).round() / 1e6;
        format!("{value}{}", self.unit)
    }
}

fn locks(capture: &CaptureSection) -> Vec<Lock> {
    let exposure = capture.exposure_s.map(|exposure_s| Lock {
        name: "exposure",
        unit: " s",
        scale: EXPOSURE_UNIT_S,
        id: id::EXPOSURE,
        value: (exposure_s / EXPOSURE_UNIT_S).round().max(1.0) as i64,
        automatics: &[(id::EXPOSURE_AUTO, MANUAL), (id::EXPOSURE_CHANGES_RATE, 0)],
    });
    let gain = capture.gain.map(|value| Lock {
        name: "gain",
        unit: "",
        scale: 1.0,
        id: id::GAIN,
        value,
        automatics: &[(id::GAIN_AUTO, 0)],
    });
    let white_balance = capture.white_balance_k.map(|kelvin| Lock {
        name: "white balance",
        unit: " K",
        scale: 1.0,
        id: id::WHITE_BALANCE,
        value: kelvin.into(),
        automatics: &[(id::WHITE_BALANCE_AUTO, 0)],
    });
    [exposure, gain, white_balance].into_iter().flatten().collect()
}

/// Sets a control and reads it back. Returns why it does not have the value; `None` if it has.
fn set(device: &mut dyn Device, id: u32, value: i64) -> Option<String> {
    if let Err(error) = device.set_control(id, value) {
        return Some(error.to_string());
    }
    match device.control(id) {
        Ok(found) if found == value => None,
        Ok(found) => Some(format!("it reads back as {found} instead of {value}")),
        Err(error) => Some(format!("it cannot be read back, {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bus;
    use crate::fake::FakeBus;
    use std::path::Path;

    fn locked(capture: &CaptureSection, prepare: impl FnOnce(&mut crate::fake::World)) -> (Vec<String>, FakeBus) {
        let bus = FakeBus::new(&["left"]);
        bus.with(prepare);
        let mut device = bus.open(Path::new("/dev/video0")).unwrap();
        (lock(device.as_mut(), capture).unwrap(), bus)
    }

    fn wanted() -> CaptureSection {
        CaptureSection {
            exposure_s: Some(0.005),
            gain: Some(16),
            white_balance_k: Some(4500),
            ..CaptureSection::default()
        }
    }

    #[test]
    fn automatics_are_switched_off_and_values_set() {
        let (differences, bus) = locked(&wanted(), |_| ());
        assert!(differences.is_empty(), "{differences:?}");
        let values = bus.with(|world| world.controls.clone());
        let value = |id: u32| values.iter().find(|(control, _)| control.id == id).unwrap().1;
        assert_eq!([value(id::EXPOSURE_AUTO), value(id::EXPOSURE)], [1, 50]);
        assert_eq!([value(id::GAIN), value(id::WHITE_BALANCE_AUTO), value(id::WHITE_BALANCE)], [16, 0, 4500]);
    }

    #[test]
    fn a_value_that_the_driver_clamps_is_reported() {
        let capture = CaptureSection { gain: Some(5000), ..CaptureSection::default() };
        let (differences, _) = locked(&capture, |_| ());
        assert_eq!(differences, ["gain is not 5000: it reads back as 100 instead of 5000; the camera takes 0 to 100"]);
    }

    #[test]
    fn a_control_that_the_camera_lacks_is_reported() {
        let (differences, _) =
            locked(&wanted(), |world| world.controls.retain(|(control, _)| control.id != id::EXPOSURE));
        assert_eq!(differences, ["exposure cannot be set: the camera has no such control"]);
    }

    #[test]
    fn without_values_no_control_is_touched() {
        let (differences, bus) = locked(&CaptureSection::default(), |_| ());
        assert!(differences.is_empty());
        assert!(bus.with(|world| {
            world.controls.iter().any(|(control, value)| control.id == id::EXPOSURE_AUTO && *value == 3)
        }));
    }
}
