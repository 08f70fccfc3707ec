//! Work compiled a second time, for processors with wide registers.
//!
//! The compiler puts like steps side by side where registers allow. Each step rounds as IEEE 754 says, with no fused
//! multiply-add, so the registers change the time and nothing else.
#![allow(unsafe_code)]

/// Does some work with the widest registers that it was compiled for and that this processor has. What it calls is
/// compiled for them where it is inlined.
#[inline(always)]
pub(crate) fn wide<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: all that the function asks for is that the processor has AVX2, which it has.
        return unsafe { with_avx2(work) };
    }
    work()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<R>(work: impl FnOnce() -> R) -> R {
    work()
}
