//! Sixteen f64, for the triangle test: the same IEEE operations, in whatever registers the processor has.
#![allow(unsafe_code)]

/// Sixteen numbers.
pub(crate) trait Doubles: Copy {
    fn splat(x: f64) -> Self;
    fn load(x: &[f64; 16]) -> Self;
    fn store(self) -> [f64; 16];
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// The larger; `other` where either is NaN.
    fn max(self, other: Self) -> Self;
    /// A bit for each lane where `self < other`; NaN is not.
    fn lt(self, other: Self) -> u32;
    /// A bit for each lane where `self <= other`; NaN is not.
    fn le(self, other: Self) -> u32;
}

/// One register.
trait Register: Copy {
    const LANES: usize;
    fn splat(x: f64) -> Self;
    /// The first lanes of a slice that holds at least [`Register::LANES`] numbers.
    fn load(x: &[f64]) -> Self;
    fn store(self, x: &mut [f64]);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn lt(self, other: Self) -> u32;
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

macro_rules! bits {
    ($method:ident, $register:ty) => {
        #[inline(always)]
        fn $method(self, other: Self) -> u32 {
            let mut bits = 0;
            for i in 0..self.0.len() {
                bits |= self.0[i].$method(other.0[i]) << (i * <$register as Register>::LANES);
            }
            bits
        }
    };
}

macro_rules! sixteen {
    ($register:ty, $registers:literal) => {
        impl Doubles for Several<$register, $registers> {
            each!(add);
            each!(sub);
            each!(mul);
            each!(div);
            each!(max);
            bits!(lt, $register);
            bits!(le, $register);
            #[inline(always)]
            fn splat(x: f64) -> Self {
                Self([<$register as Register>::splat(x); $registers])
            }
            #[inline(always)]
            fn load(x: &[f64; 16]) -> Self {
                let mut out = [<$register as Register>::splat(0.0); $registers];
                for i in 0..$registers {
                    out[i] = <$register as Register>::load(&x[i * <$register as Register>::LANES..]);
                }
                Self(out)
            }
            #[inline(always)]
            fn store(self) -> [f64; 16] {
                let mut out = [0.0; 16];
                for i in 0..$registers {
                    self.0[i].store(&mut out[i * <$register as Register>::LANES..]);
                }
                out
            }
        }
    };
}

impl Register for f64 {
    const LANES: usize = 1;
    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn load(x: &[f64]) -> Self {
        x[0]
    }
    #[inline(always)]
    fn store(self, x: &mut [f64]) {
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
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        u32::from(self < other)
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        u32::from(self <= other)
    }
}

sixteen!(f64, 16);

#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{Avx2Doubles, Avx512Doubles, Sse2Doubles};
/// Plain Rust.
pub(crate) type PortableDoubles = Several<f64, 16>;

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Doubles, Register, Several};
    use core::arch::x86_64::{
        __m128d, __m256d, __m512d, _CMP_LE_OQ, _CMP_LT_OQ, _mm_add_pd, _mm_cmple_pd, _mm_cmplt_pd, _mm_div_pd,
        _mm_loadu_pd, _mm_max_pd, _mm_movemask_pd, _mm_mul_pd, _mm_set1_pd, _mm_storeu_pd, _mm_sub_pd, _mm256_add_pd,
        _mm256_cmp_pd, _mm256_div_pd, _mm256_loadu_pd, _mm256_max_pd, _mm256_movemask_pd, _mm256_mul_pd,
        _mm256_set1_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm512_add_pd, _mm512_cmp_pd_mask, _mm512_div_pd,
        _mm512_loadu_pd, _mm512_max_pd, _mm512_mul_pd, _mm512_set1_pd, _mm512_storeu_pd, _mm512_sub_pd,
    };

    pub(crate) type Sse2Doubles = Several<__m128d, 8>;
    pub(crate) type Avx2Doubles = Several<__m256d, 4>;
    pub(crate) type Avx512Doubles = Several<__m512d, 2>;

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
         $div:ident, $max:ident, |$a:ident, $b:ident| $lt:expr, $le:expr) => {
            impl Register for $register {
                const LANES: usize = $lanes;
                binary!(add, $add);
                binary!(sub, $sub);
                binary!(mul, $mul);
                binary!(div, $div);
                binary!(max, $max);
                #[inline(always)]
                fn splat(x: f64) -> Self {
                    // SAFETY: as above.
                    unsafe { $set1(x) }
                }
                #[inline(always)]
                fn load(x: &[f64]) -> Self {
                    let lanes = &x[..$lanes];
                    // SAFETY: as above; the slice holds all lanes, and the load needs no alignment.
                    unsafe { $loadu(lanes.as_ptr()) }
                }
                #[inline(always)]
                fn store(self, x: &mut [f64]) {
                    let lanes = &mut x[..$lanes];
                    // SAFETY: as above; the slice holds all lanes, and the store needs no alignment.
                    unsafe { $storeu(lanes.as_mut_ptr(), self) }
                }
                #[inline(always)]
                fn lt(self, other: Self) -> u32 {
                    let ($a, $b) = (self, other);
                    // SAFETY: as above.
                    unsafe { $lt }
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
        __m128d,
        2,
        _mm_set1_pd,
        _mm_loadu_pd,
        _mm_storeu_pd,
        _mm_add_pd,
        _mm_sub_pd,
        _mm_mul_pd,
        _mm_div_pd,
        _mm_max_pd,
        |a, b| _mm_movemask_pd(_mm_cmplt_pd(a, b)).cast_unsigned(),
        _mm_movemask_pd(_mm_cmple_pd(a, b)).cast_unsigned()
    );
    register!(
        __m256d,
        4,
        _mm256_set1_pd,
        _mm256_loadu_pd,
        _mm256_storeu_pd,
        _mm256_add_pd,
        _mm256_sub_pd,
        _mm256_mul_pd,
        _mm256_div_pd,
        _mm256_max_pd,
        |a, b| _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a, b)).cast_unsigned(),
        _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(a, b)).cast_unsigned()
    );
    register!(
        __m512d,
        8,
        _mm512_set1_pd,
        _mm512_loadu_pd,
        _mm512_storeu_pd,
        _mm512_add_pd,
        _mm512_sub_pd,
        _mm512_mul_pd,
        _mm512_div_pd,
        _mm512_max_pd,
        |a, b| u32::from(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b)),
        u32::from(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b))
    );

    sixteen!(__m128d, 8);
    sixteen!(__m256d, 4);
    sixteen!(__m512d, 2);
}
