//! Lanes of f32: the same IEEE operations, eight or sixteen at a time, in whatever registers the processor has.
//!
//! What is computed in lanes only proposes (see the crate's docs), and every operation here rounds once, as IEEE 754 says;
//! so the instruction set changes the time an answer takes and nothing else. No fused multiply-add, no approximate
//! reciprocals.
//!
//! With `scene/src/wide.rs`, the only module of the project with `unsafe` code: vector instructions, and the calls into code that was
//! compiled for them.
#![allow(unsafe_code)]

mod doubles;

pub(crate) use doubles::Doubles;
use doubles::PortableDoubles;

/// Which vector instructions the tracer uses. The answers are the same; the time is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InstructionSet {
    /// Plain Rust, for every target.
    Portable,
    /// 128-bit registers; every x86-64 processor.
    Sse2,
    /// 256-bit registers.
    Avx2,
    /// 512-bit registers.
    Avx512,
}

impl InstructionSet {
    /// All of them, narrowest first.
    pub const ALL: [Self; 4] = [Self::Portable, Self::Sse2, Self::Avx2, Self::Avx512];

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return match self {
            Self::Portable | Self::Sse2 => true,
            Self::Avx2 => is_x86_feature_detected!("avx2"),
            Self::Avx512 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("avx512f"),
        };
        #[cfg(not(target_arch = "x86_64"))]
        return self == Self::Portable;
    }

    /// The widest that this processor has.
    pub fn widest() -> Self {
        Self::ALL.into_iter().rev().find(|i| i.is_available()).unwrap_or(Self::Portable)
    }
}

/// `N` numbers.
pub(crate) trait Wide<const N: usize>: Copy {
    fn splat(x: f32) -> Self;
    fn load(x: &[f32; N]) -> Self;
    /// Whole numbers, exactly.
    fn load_u16(x: &[u16; N]) -> Self;
    fn store(self) -> [f32; N];
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// The smaller; `other` where either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger; `other` where either is NaN.
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    /// A bit for each lane where `self <= other`; NaN is not.
    fn le(self, other: Self) -> u32;
}

/// One processor's lanes.
pub(crate) trait Lanes: Copy {
    /// Who they belong to.
    const SET: InstructionSet;
    type X8: Wide<8>;
    type X16: Wide<16>;
    type D16: Doubles;
}

/// One register.
trait Register: Copy {
    const LANES: usize;
    fn splat(x: f32) -> Self;
    /// The first lanes of a slice that holds at least [`Register::LANES`] numbers.
    fn load(x: &[f32]) -> Self;
    /// The same of whole numbers.
    fn load_u16(x: &[u16]) -> Self;
    fn store(self, x: &mut [f32]);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    fn le(self, other: Self) -> u32;
}

/// Several registers side by side.
#[derive(Clone, Copy)]
pub(crate) struct Several<R, const K: usize>([R; K]);

macro_rules! each {
    ($method:ident) => {
        #[inline(always)]
        fn $method(self, other: Self) -> Self {
            let mut out = self;
            for i in 0..out.0.len() {
                out.0[i] = self.0[i].$method(other.0[i]);
            }
            out
        }
    };
}

macro_rules! wide {
    ($register:ty, $registers:literal, $lanes:literal) => {
        impl Wide<$lanes> for Several<$register, $registers> {
            each!(add);
            each!(sub);
            each!(mul);
            each!(div);
            each!(min);
            each!(max);
            #[inline(always)]
            fn splat(x: f32) -> Self {
                Self([<$register as Register>::splat(x); $registers])
            }
            #[inline(always)]
            fn load(x: &[f32; $lanes]) -> Self {
                let mut out = [<$register as Register>::splat(0.0); $registers];
                for i in 0..$registers {
                    out[i] = <$register as Register>::load(&x[i * <$register as Register>::LANES..]);
                }
                Self(out)
            }
            #[inline(always)]
            fn load_u16(x: &[u16; $lanes]) -> Self {
                let mut out = [<$register as Register>::splat(0.0); $registers];
                for i in 0..$registers {
                    out[i] = <$register as Register>::load_u16(&x[i * <$register as Register>::LANES..]);
                }
                Self(out)
            }
            #[inline(always)]
            fn store(self) -> [f32; $lanes] {
                let mut out = [0.0; $lanes];
                for i in 0..$registers {
                    self.0[i].store(&mut out[i * <$register as Register>::LANES..]);
                }
                out
            }
            #[inline(always)]
            fn abs(self) -> Self {
                let mut out = self;
                for i in 0..$registers {
                    out.0[i] = self.0[i].abs();
                }
                out
            }
            #[inline(always)]
            fn le(self, other: Self) -> u32 {
                let mut bits = 0;
                for i in 0..$registers {
                    bits |= self.0[i].le(other.0[i]) << (i * <$register as Register>::LANES);
                }
                bits
            }
        }
    };
}

/// Plain Rust.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

impl Lanes for Portable {
    const SET: InstructionSet = InstructionSet::Portable;
    type X8 = Several<f32, 8>;
    type X16 = Several<f32, 16>;
    type D16 = PortableDoubles;
}

impl Register for f32 {
    const LANES: usize = 1;
    #[inline(always)]
    fn splat(x: f32) -> Self {
        x
    }
    #[inline(always)]
    fn load(x: &[f32]) -> Self {
        x[0]
    }
    #[inline(always)]
    fn load_u16(x: &[u16]) -> Self {
        f32::from(x[0])
    }
    #[inline(always)]
    fn store(self, x: &mut [f32]) {
        x[0] = self;
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self * other
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self / other
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        u32::from(self <= other)
    }
}

wide!(f32, 8, 8);
wide!(f32, 16, 16);

#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{Avx2, Avx512, Sse2};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::doubles::{Avx2Doubles, Avx512Doubles, Sse2Doubles};
    use super::{InstructionSet, Lanes, Register, Several, Wide};
    use core::arch::x86_64::{
        __m128, __m256, __m512, _CMP_LE_OQ, _mm_add_ps, _mm_andnot_ps, _mm_cmple_ps, _mm_cvtepi32_ps, _mm_div_ps,
        _mm_loadl_epi64, _mm_loadu_ps, _mm_loadu_si128, _mm_max_ps, _mm_min_ps, _mm_movemask_ps, _mm_mul_ps,
        _mm_set1_ps, _mm_setzero_si128, _mm_storeu_ps, _mm_sub_ps, _mm_unpacklo_epi16, _mm256_add_ps, _mm256_andnot_ps,
        _mm256_cmp_ps, _mm256_cvtepi32_ps, _mm256_cvtepu16_epi32, _mm256_div_ps, _mm256_loadu_ps, _mm256_loadu_si256,
        _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_set1_ps, _mm256_storeu_ps,
        _mm256_sub_ps, _mm512_abs_ps, _mm512_add_ps, _mm512_cmp_ps_mask, _mm512_cvtepi32_ps, _mm512_cvtepu16_epi32,
        _mm512_div_ps, _mm512_loadu_ps, _mm512_max_ps, _mm512_min_ps, _mm512_mul_ps, _mm512_set1_ps, _mm512_storeu_ps,
        _mm512_sub_ps,
    };

    /// 128-bit registers.
    #[derive(Clone, Copy)]
    pub(crate) struct Sse2;
    /// 256-bit registers.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx2;
    /// 512-bit registers.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx512;

    impl Lanes for Sse2 {
        const SET: InstructionSet = InstructionSet::Sse2;
        type X8 = Several<__m128, 2>;
        type X16 = Several<__m128, 4>;
        type D16 = Sse2Doubles;
    }
    impl Lanes for Avx2 {
        const SET: InstructionSet = InstructionSet::Avx2;
        type X8 = Several<__m256, 1>;
        type X16 = Several<__m256, 2>;
        type D16 = Avx2Doubles;
    }
    impl Lanes for Avx512 {
        const SET: InstructionSet = InstructionSet::Avx512;
        type X8 = Several<__m256, 1>;
        type X16 = Several<__m512, 1>;
        type D16 = Avx512Doubles;
    }

    macro_rules! binary {
        ($method:ident, $instruction:ident) => {
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: `dispatch!` asked the processor before any code of this instruction set runs.
                unsafe { $instruction(self, other) }
            }
        };
    }

    macro_rules! register {
        ($register:ty, $lanes:literal, $set1:ident, $loadu:ident, $storeu:ident, $add:ident, $sub:ident, $mul:ident,
         $div:ident, $min:ident, $max:ident, |$x:ident| $abs:expr, |$a:ident, $b:ident| $le:expr, |$p:ident| $load_u16:expr) => {
            impl Register for $register {
                const LANES: usize = $lanes;
                binary!(add, $add);
                binary!(sub, $sub);
                binary!(mul, $mul);
                binary!(div, $div);
                binary!(min, $min);
                binary!(max, $max);
                #[inline(always)]
                fn splat(x: f32) -> Self {
                    // SAFETY: as above.
                    unsafe { $set1(x) }
                }
                #[inline(always)]
                fn load(x: &[f32]) -> Self {
                    let lanes = &x[..$lanes];
                    // SAFETY: as above; the slice holds all lanes, and the load needs no alignment.
                    unsafe { $loadu(lanes.as_ptr()) }
                }
                #[inline(always)]
                fn load_u16(x: &[u16]) -> Self {
                    let $p = x[..$lanes].as_ptr();
                    // SAFETY: as above; the slice holds all lanes, and the load needs no alignment.
                    unsafe { $load_u16 }
                }
                #[inline(always)]
                fn store(self, x: &mut [f32]) {
                    let lanes = &mut x[..$lanes];
                    // SAFETY: as above; the slice holds all lanes, and the store needs no alignment.
                    unsafe { $storeu(lanes.as_mut_ptr(), self) }
                }
                #[inline(always)]
                fn abs(self) -> Self {
                    let $x = self;
                    // SAFETY: as above.
                    unsafe { $abs }
                }
                #[inline(always)]
                fn le(self, other: Self) -> u32 {
                    let ($a, $b) = (self, other);
                    // SAFETY: as above.
                    unsafe { $le }
                }
            }
        };
    }

    register!(
        __m128,
        4,
        _mm_set1_ps,
        _mm_loadu_ps,
        _mm_storeu_ps,
        _mm_add_ps,
        _mm_sub_ps,
        _mm_mul_ps,
        _mm_div_ps,
        _mm_min_ps,
        _mm_max_ps,
        |x| _mm_andnot_ps(_mm_set1_ps(-0.0), x),
        |a, b| _mm_movemask_ps(_mm_cmple_ps(a, b)).cast_unsigned(),
        |p| _mm_cvtepi32_ps(_mm_unpacklo_epi16(_mm_loadl_epi64(p.cast()), _mm_setzero_si128()))
    );
    register!(
        __m256,
        8,
        _mm256_set1_ps,
        _mm256_loadu_ps,
        _mm256_storeu_ps,
        _mm256_add_ps,
        _mm256_sub_ps,
        _mm256_mul_ps,
        _mm256_div_ps,
        _mm256_min_ps,
        _mm256_max_ps,
        |x| _mm256_andnot_ps(_mm256_set1_ps(-0.0), x),
        |a, b| _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)).cast_unsigned(),
        |p| _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm_loadu_si128(p.cast())))
    );
    register!(
        __m512,
        16,
        _mm512_set1_ps,
        _mm512_loadu_ps,
        _mm512_storeu_ps,
        _mm512_add_ps,
        _mm512_sub_ps,
        _mm512_mul_ps,
        _mm512_div_ps,
        _mm512_min_ps,
        _mm512_max_ps,
        |x| _mm512_abs_ps(x),
        |a, b| u32::from(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b)),
        |p| _mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(_mm256_loadu_si256(p.cast())))
    );

    wide!(__m128, 2, 8);
    wide!(__m128, 4, 16);
    wide!(__m256, 1, 8);
    wide!(__m256, 2, 16);
    wide!(__m512, 1, 16);
}

/// Has the processor fetch what will be read soon.
#[inline(always)]
pub(crate) fn prefetch<T>(of: &T) {
    #[cfg(target_arch = "x86_64")]
    for line in (0..size_of::<T>()).step_by(64) {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 processor has it, it reads nothing, and the address lies within a reference's target.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(core::ptr::from_ref(of).cast::<i8>().add(line)) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = of;
}

/// Makes a function that runs a generic one, compiled for an instruction set:
/// `dispatch!(fn name(arguments) -> type = generic_function)`. The generic function and all that it calls in the inner
/// loop must be `#[inline(always)]`.
macro_rules! dispatch {
    ($(#[$meta:meta])* fn $name:ident<$q:ident: $bound:path>($($argument:ident: $type:ty),* $(,)?) = $run:path) => {
        $(#[$meta])*
        #[allow(unsafe_code)]
        pub(crate) fn $name<$q: $bound>(set: $crate::simd::InstructionSet, $($argument: $type),*) {
            use $crate::simd::InstructionSet;
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
                fn avx2<$q: $bound>($($argument: $type),*) {
                    $run($crate::simd::Avx2, $($argument),*);
                }
                #[target_feature(enable = "avx512f,avx2,bmi1,bmi2,lzcnt,popcnt")]
                fn avx512<$q: $bound>($($argument: $type),*) {
                    $run($crate::simd::Avx512, $($argument),*);
                }
                match set {
                    // SAFETY: `Tracer` holds an instruction set that the processor said it has.
                    InstructionSet::Avx512 => return unsafe { avx512($($argument),*) },
                    // SAFETY: as above.
                    InstructionSet::Avx2 => return unsafe { avx2($($argument),*) },
                    InstructionSet::Sse2 => return $run($crate::simd::Sse2, $($argument),*),
                    InstructionSet::Portable => {}
                }
            }
            let _ = set == InstructionSet::Portable;
            $run($crate::simd::Portable, $($argument),*);
        }
    };
}
pub(crate) use dispatch;
