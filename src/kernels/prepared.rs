//! `prepared!`: the struct of a prepared primitive, and how one primitive becomes eight.
//!
//! The struct is written as usual, generic over the lanes `P`. A field is `P` (a number), `P::Vec3`, or another
//! prepared struct such as `Slabs<P>`. The macro adds the derives and three functions, which only copy numbers:
//!
//! - `gather` puts eight primitives into the lanes of one struct.
//! - `lane` takes one of them out again.
//! - `widen` makes any primitive eight lanes wide: one becomes eight copies, eight stay as they are.
//!
//! `prepared!(gather, lane);` in an `impl Kernel` implements the trait's functions by the first two. Arithmetic is
//! never generated.

macro_rules! prepared {
    ($(#[$attribute:meta])* $vis:vis struct $Name:ident<P: Lanes> {
        $(
            $(#[$field_attribute:meta])*
            $field_vis:vis $field:ident: $Type:ident $(::$Vec3:ident)? $(<$P:ident>)?,
        )*
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $vis struct $Name<P: Lanes> {
            $(
                $(#[$field_attribute])*
                $field_vis $field: $Type $(::$Vec3)? $(<$P>)?,
            )*
        }

        impl $Name<wide::f32x8> {
            pub(crate) fn gather(primitives: &[$Name<f32>; 8]) -> Self {
                Self { $($field: prepared!(@gather primitives.map(|one| one.$field), $Type $(::$Vec3)? $(<$P>)?),)* }
            }

            #[inline(always)]
            pub(crate) fn lane(&self, lane: usize) -> $Name<f32> {
                $Name { $($field: prepared!(@lane self.$field, lane, $Type $(::$Vec3)? $(<$P>)?),)* }
            }
        }

        impl<P: Lanes> $Name<P> {
            #[inline(always)]
            pub(crate) fn widen(&self) -> $Name<wide::f32x8> {
                $Name { $($field: prepared!(@widen self.$field, $Type $(::$Vec3)? $(<$P>)?),)* }
            }
        }
    };

    (gather, lane) => {
        fn gather(primitives: &[Self; 8]) -> Self::Packet {
            Self::Packet::gather(primitives)
        }

        #[inline(always)]
        fn lane(packet: &Self::Packet, lane: usize) -> Self {
            packet.lane(lane)
        }
    };

    (@gather $eight:expr, P) => { wide::f32x8::new($eight) };
    (@gather $eight:expr, P::Vec3) => { $crate::geom::Vec3x8::from_lanes($eight) };
    (@gather $eight:expr, $Part:ident<P>) => { $Part::gather(&$eight) };

    (@lane $eight:expr, $lane:expr, P) => { $eight.as_array()[$lane] };
    (@lane $eight:expr, $lane:expr, $($type:tt)+) => { $eight.lane($lane) };

    // By name for each vector: see `Lanes::widen_vec3`.
    (@widen $one:expr, P::Vec3) => { P::widen_vec3($one) };
    (@widen $one:expr, $($type:tt)+) => { $one.widen() };
}
