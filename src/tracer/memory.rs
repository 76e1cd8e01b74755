//! Asks for memory before long work, because Rust ends a program that runs out of it.

use std::hint::black_box;

/// Returns an explanation if the system does not grant this many bytes at once. They are given back immediately.
pub fn check_memory(bytes: usize) -> Result<(), String> {
    let mut memory = Vec::<u8>::new();
    let granted = memory.try_reserve_exact(bytes);
    // Otherwise the compiler may leave out an allocation that nobody uses.
    black_box(&memory);
    granted.map_err(|_| format!("not enough memory: this takes about {:.2} GB", bytes as f64 / 1e9))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_system_grants_is_accepted() {
        assert_eq!(check_memory(1 << 20), Ok(()));
        let message = "not enough memory: this takes about 9223372036.85 GB".to_owned();
        assert_eq!(check_memory(isize::MAX.cast_unsigned()), Err(message.clone()));
        assert_eq!(check_memory(isize::MAX.cast_unsigned() + 1), Err(message));
    }
}
