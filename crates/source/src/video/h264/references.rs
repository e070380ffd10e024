//! Refuses slices with more reference pictures than H.264 allows.
//!
//! The decoder repeats the last reference picture as often as a slice asks for it, and a damaged slice asks for billions.
//! The slice's header is therefore read before the decoder gets it.

use std::collections::BTreeMap;

use crate::guarded::guarded;
use rust_h264::nal::{NalUnit, NalUnitType};
use rust_h264::pps::{Pps, parse_pps};
use rust_h264::slice::parse_slice_header;
use rust_h264::sps::{Sps, parse_sps};

/// The most entries of a list of reference pictures (H.264, 7.4.3: `num_ref_idx_l0_active_minus1` is at most 31).
const MAX_ENTRIES: u32 = 32;

/// The parameter sets of a stream by their number, as far as they can be read.
#[derive(Default)]
pub(super) struct References {
    sequences: BTreeMap<u32, Sps>,
    pictures: BTreeMap<u32, Pps>,
}

impl References {
    /// Keeps a parameter set, or checks a slice. What cannot be read is left to the decoder, which refuses it.
    pub(super) fn check(&mut self, unit: &NalUnit) -> Result<(), String> {
        match unit.nal_unit_type {
            NalUnitType::Sps => {
                if let Ok(set) = guarded(|| parse_sps(&unit.rbsp))? {
                    self.sequences.insert(set.seq_parameter_set_id, set);
                }
            }
            NalUnitType::Pps => {
                if let Ok(set) = guarded(|| parse_pps(&unit.rbsp, None))? {
                    self.pictures.insert(set.pic_parameter_set_id, set);
                }
            }
            NalUnitType::Slice | NalUnitType::SliceIdr | NalUnitType::SliceDataA => {
                let most = guarded(|| self.entries(unit))?;
                if most > MAX_ENTRIES {
                    return Err(format!("a slice with {most} reference pictures, {MAX_ENTRIES} are allowed"));
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// The entries of the longer one of a slice's lists; 0 if its header cannot be read.
    fn entries(&self, slice: &NalUnit) -> u32 {
        self.pictures
            .values()
            .filter_map(|picture| {
                let sequence = self.sequences.get(&picture.seq_parameter_set_id)?;
                let (kind, importance) = (slice.nal_unit_type, slice.nal_ref_idc);
                let (header, _) = parse_slice_header(&slice.rbsp, sequence, picture, kind, importance).ok()?;
                // A header is read with every set; it names the set to which it belongs.
                let is_its_own = header.pic_parameter_set_id == picture.pic_parameter_set_id;
                is_its_own.then_some(header.num_ref_idx_l0_active.max(header.num_ref_idx_l1_active))
            })
            .max()
            .unwrap_or(0)
    }
}
