//! Which vector registers the engine uses. Results do not depend on it: [`choose`] is there to show that.

use std::sync::OnceLock;

use pulp::{Arch, Simd, WithSimd};

/// The registers of all loops, once the first of them has run or somebody has chosen.
static USED: OnceLock<Arch> = OnceLock::new();

/// Vector registers of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Registers {
    /// One number at a time: what every processor can.
    Baseline,
    /// NEON: 4 numbers of single precision.
    Neon,
    /// AVX2: 8 of them.
    Avx2,
    /// AVX-512: 16 of them.
    Avx512,
}

/// Why registers cannot be chosen.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RegistersError {
    /// No such word.
    #[error("{0:?}: must be one of {words}", words = words(Registers::ALL))]
    Unknown(String),
    /// The processor has none of this kind.
    #[error("{:?}: this processor lacks it; it has {words}", .0.word(), words = words(Registers::here()))]
    Lacking(Registers),
    /// Loops have run with others.
    #[error("{:?}: others are in use already; choose before anything is simulated", .0.word())]
    Late(Registers),
}

fn words(registers: impl IntoIterator<Item = Registers>) -> String {
    registers.into_iter().map(Registers::word).collect::<Vec<_>>().join(", ")
}

impl Registers {
    /// From the narrowest on.
    pub const ALL: [Self; 4] = [Self::Baseline, Self::Neon, Self::Avx2, Self::Avx512];

    /// Those of this processor, from the narrowest on.
    pub fn here() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|registers| registers.arch().is_some())
    }

    /// What users call them.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Neon => "neon",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    fn arch(self) -> Option<Arch> {
        match self {
            Self::Baseline => Some(Arch::Scalar),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => pulp::aarch64::Neon::try_new().map(Arch::Neon),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => pulp::x86::V3::try_new().map(Arch::V3),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => pulp::x86::V4::try_new().map(Arch::V4),
            _ => None,
        }
    }
}

/// Has all loops of this process use the registers of this name, in place of the widest ones.
///
/// # Errors
/// There is no such name, this processor has no such registers, or others are in use already.
pub fn choose(word: &str) -> Result<(), RegistersError> {
    let named = Registers::ALL.into_iter().find(|registers| registers.word() == word);
    let registers = named.ok_or_else(|| RegistersError::Unknown(word.to_owned()))?;
    let arch = registers.arch().ok_or(RegistersError::Lacking(registers))?;
    let same = std::mem::discriminant(USED.get_or_init(|| arch)) == std::mem::discriminant(&arch);
    if same { Ok(()) } else { Err(RegistersError::Late(registers)) }
}

/// What every loop is dispatched with: the widest registers of this processor, unless somebody chose others.
#[inline]
#[must_use]
pub fn arch() -> Arch {
    // Miri knows no vector registers.
    *USED.get_or_init(|| if cfg!(miri) { Arch::Scalar } else { Arch::new() })
}

struct Lanes;

impl WithSimd for Lanes {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F32_LANES
    }
}

/// Numbers of single precision that one of the vector registers in use holds: 16 with AVX-512, 8 with AVX2, 4 with
/// NEON, 1 where there is none. Results do not depend on it.
pub fn lanes() -> usize {
    arch().dispatch(Lanes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_chosen_is_told() {
        assert_eq!(choose("sse9").unwrap_err().to_string(), "\"sse9\": must be one of baseline, neon, avx2, avx512");
        assert_eq!(Registers::here().next(), Some(Registers::Baseline));
        for lacking in Registers::ALL.into_iter().filter(|registers| registers.arch().is_none()) {
            let told = choose(lacking.word()).unwrap_err().to_string();
            assert!(told.contains("this processor lacks it; it has baseline"), "{told}");
        }
        let in_use = lanes();
        let late = choose(if in_use == 1 { "avx2" } else { "baseline" }).unwrap_err();
        assert!(matches!(late, RegistersError::Late(_) | RegistersError::Lacking(_)), "{late}");
        assert_eq!(lanes(), in_use);
    }
}
