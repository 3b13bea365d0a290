//! Where a WebAssembly component keeps its model: the component is the same for all, and the packer writes the model's
//! bytes into its file.

/// In front of the place.
const MARKER: [u8; 24] = *b"the model of piezoloop: ";
/// Bytes of a model at most.
pub const MOST: usize = 2 << 20;

/// The place, as it lies in the component's file.
#[repr(C)]
pub struct Slot {
    marker: [u8; 24],
    length: u32,
    bytes: [u8; MOST],
}

impl Slot {
    /// Without a model.
    pub const EMPTY: Self = Self { marker: MARKER, length: 0, bytes: [0; MOST] };

    /// The model's bytes, where the packer has written some.
    #[must_use]
    pub fn model(&'static self) -> Option<&'static [u8]> {
        // The packer has changed what the compiler has seen.
        let slot = std::hint::black_box(self);
        slot.bytes.get(..slot.length as usize).filter(|bytes| !bytes.is_empty())
    }
}

/// Writes a model into a component.
///
/// # Errors
/// The component has no place, or the model does not fit.
pub fn put(component: &mut [u8], model: &[u8]) -> Result<(), String> {
    let mut places =
        component.windows(MARKER.len()).enumerate().filter(|(_, part)| **part == MARKER);
    let (Some((at, _)), None) = (places.next(), places.next()) else {
        return Err("the component in this program is damaged: it has no place for a model".into());
    };
    if model.len() > MOST {
        return Err(format!(
            "the model has {} bytes, and a WebAssembly component takes {MOST}; identify with less data or fewer \
             support vectors, or leave out --wasm",
            model.len()
        ));
    }
    let start = at + MARKER.len();
    let place = component.get_mut(start..start + 4 + model.len());
    let place = place.ok_or("the component in this program is damaged: it ends early")?;
    let (length, bytes) = place.split_at_mut(4);
    length.copy_from_slice(&(model.len() as u32).to_le_bytes());
    bytes.copy_from_slice(model);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_lies_where_the_component_reads_it() {
        assert_eq!(std::mem::offset_of!(Slot, length), MARKER.len());
        assert_eq!(std::mem::offset_of!(Slot, bytes), MARKER.len() + 4);
        let mut file = [b"before".as_slice(), &MARKER, &[0; 12], b"behind"].concat();
        put(&mut file, &[7, 8, 9]).unwrap();
        assert_eq!(
            file[30..],
            [3, 0, 0, 0, 7, 8, 9, 0, 0, 0, 0, 0, b'b', b'e', b'h', b'i', b'n', b'd']
        );
    }

    #[test]
    fn what_has_no_place_or_does_not_fit_is_refused() {
        assert!(put(&mut [0; 99], &[1]).unwrap_err().contains("no place"));
        assert!(put(&mut MARKER.repeat(2), &[1]).unwrap_err().contains("no place"));
        assert!(put(&mut MARKER.to_vec(), &[1]).unwrap_err().contains("ends early"));
        let error = put(&mut MARKER.to_vec(), &vec![0; MOST + 1]).unwrap_err();
        assert!(error.contains("2097153 bytes") && error.contains("takes 2097152"), "{error}");
    }
}
