//! LZF, by which PCD files are compressed (Marc Lehmann's liblzf): runs of literal bytes, and
//! copies of what was written before.

/// Longest run of literal bytes; a first byte below says one.
const LITERALS: u8 = 32;

/// What `packed` stands for, which has `size` bytes.
///
/// # Errors
/// Another size, a copy from before the beginning, an end within a run.
pub(super) fn unpack(packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let mut input = Input { packed, at: 0 };
    let mut out = Vec::with_capacity(size);
    while input.at < packed.len() {
        let control = input.byte()?;
        if control < LITERALS {
            out.extend(input.take(usize::from(control) + 1)?);
        } else {
            input.copy(control, &mut out)?;
        }
        if out.len() > size {
            break;
        }
    }
    match out.len() == size {
        true => Ok(out),
        false => Err(format!(
            "its compressed part is damaged: it has {} bytes unpacked, not {size}",
            out.len()
        )),
    }
}

struct Input<'a> {
    packed: &'a [u8],
    at: usize,
}

impl<'a> Input<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let part = self.packed.get(self.at..self.at + count);
        self.at += count;
        part.ok_or_else(|| "its compressed part ends within a run".to_owned())
    }

    fn byte(&mut self) -> Result<u8, String> {
        Ok(self.take(1)?[0])
    }

    /// Writes again what was written so far back as the next bytes say; it may run into itself.
    fn copy(&mut self, control: u8, out: &mut Vec<u8>) -> Result<(), String> {
        let mut length = usize::from(control >> 5);
        if length == 7 {
            length += usize::from(self.byte()?);
        }
        let back = usize::from(control & 0x1f) << 8 | usize::from(self.byte()?);
        let from = out
            .len()
            .checked_sub(back + 1)
            .ok_or("its compressed part copies from before its beginning")?;
        for index in from..from + length + 2 {
            out.push(out[index]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_copies_are_unpacked() {
        // "abc", six bytes from three back, which runs into itself, and a long copy.
        let packed = [2, b'a', b'b', b'c', 4 << 5, 2, 7 << 5, 3, 2];
        let wanted = b"abcabcabcabcabcabcabc";
        assert_eq!(unpack(&packed, wanted.len()).unwrap(), wanted);
    }

    #[test]
    fn damage_is_refused() {
        for (packed, size, part) in [
            (&[2, b'a'][..], 3, "ends within a run"),
            (&[1 << 5, 0], 3, "before its beginning"),
            (&[0, b'a'], 2, "1 bytes unpacked, not 2"),
            (&[0, b'a', 7 << 5, 255, 0], 9, "not 9"),
        ] {
            let text = unpack(packed, size).unwrap_err();
            assert!(text.contains(part), "{text}");
        }
    }
}
