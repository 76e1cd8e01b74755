//! Quadrics: along the ray the surface's equation is a polynomial of second degree in `t`, and its roots are the
//! candidates.
//!
//! Two signs tell how a root compares with a given `t`: that of the polynomial there, and that of its slope. So the
//! decision needs no square root. Only the chosen root has to be rounded.

use core::cmp::Ordering;

use crate::geom::{Placed, Quadric, Ray};

use super::aabb::{Bound, Segment};
use super::exact::Dyadic;
use super::number::{Line, Linear, Number, Root, dot};
use super::{ExactHit, HIT, Locate, Truth, can_hit};

impl Locate for Quadric {
    fn locate<N: Number>(&self, ray: &Ray<f32>) -> Option<Truth> {
        if can_hit(ray) { truth(self, &Line::<N>::of(ray), ray) } else { Some(Truth::MISS) }
    }

    fn locate_hit(&self, ray: &Ray<f32>, truth: &Truth) -> ExactHit {
        hit(self, &Line::of(ray), ray, truth, |gradient| gradient)
    }
}

impl Locate for Placed<Quadric> {
    fn locate<N: Number>(&self, ray: &Ray<f32>) -> Option<Truth> {
        if !can_hit(ray) {
            return Some(Truth::MISS);
        }
        let line = Line::<N>::in_object_space(&self.object_to_world, ray)?;
        line.map_or(Some(Truth::MISS), |line| truth(&self.shape, &line, ray))
    }

    fn locate_hit(&self, ray: &Ray<f32>, truth: &Truth) -> ExactHit {
        let line = Line::in_object_space(&self.object_to_world, ray).flatten().expect(HIT);
        let linear = Linear::<Dyadic>::of(&self.object_to_world).flatten().expect(HIT);
        hit(&self.shape, &line, ray, truth, |gradient| linear.apply_adjugate_transposed(&gradient))
    }
}

/// The hit at the root that rounds to the true `t`. `to_world` transforms a gradient to the world, and may multiply it
/// by a positive number.
fn hit(
    shape: &Quadric,
    line: &Line<Dyadic>,
    ray: &Ray<f32>,
    truth: &Truth,
    to_world: impl FnOnce([Dyadic; 3]) -> [Dyadic; 3],
) -> ExactHit {
    let polynomial = Polynomial::of(shape, line).flatten().expect(HIT);
    let mut quotients = polynomial.distinct_roots().iter().map(|&root| polynomial.quotient(root));
    let quotient = quotients.find(|[num, den]| num.divided_by(den) == Some(truth.t)).expect(HIT);
    ExactHit::at(ray, quotient, |num, den| {
        // The point in the coordinates of the quadric, times `weight`.
        let point = [0, 1, 2].map(|axis| line.origin[axis].times(den).plus(&num.times(&line.dir[axis])));
        let weight = line.scaled(den.clone());
        let [squares, products, linear] = Dyadic::vectors([shape.squares, shape.products, shape.linear]);
        let curved = hessian(&squares, &products, &point);
        to_world([0, 1, 2].map(|axis| curved[axis].plus(&linear[axis].times(&weight))))
    })
}

/// H·`v`. H is the matrix of second derivatives: 2f(p) = p·Hp + 2·linear·p + 2·constant.
fn hessian<N: Number>(squares: &[N; 3], products: &[N; 3], v: &[N; 3]) -> [N; 3] {
    [(0, 1, 2), (1, 2, 0), (2, 0, 1)].map(|(i, j, k)| {
        let square = squares[i].plus(&squares[i]).times(&v[i]);
        square.plus(&products[k].times(&v[j])).plus(&products[j].times(&v[k]))
    })
}

fn truth<N: Number>(shape: &Quadric, line: &Line<N>, ray: &Ray<f32>) -> Option<Truth> {
    if !shape.is_finite() {
        return Some(Truth::MISS);
    }
    let Some(polynomial) = Polynomial::of(shape, line)? else {
        return Some(Truth::MISS);
    };
    let Some(segment) = Segment::of(&shape.clip, line, ray)? else {
        return Some(Truth::MISS);
    };
    let (entry, exit) = (polynomial.roots_from(&segment.entry)?, polynomial.roots_from(&segment.exit)?);
    for &root in polynomial.distinct_roots() {
        let (from_entry, from_exit) = (entry[root as usize], exit[root as usize]);
        if from_entry.is_ge() && from_exit.is_le() {
            let at_an_end = from_entry.is_eq() | from_exit.is_eq();
            let boundary = at_an_end | segment.in_box_plane | (polynomial.kind == Kind::Double);
            return Some(Truth { hit: true, boundary, t: polynomial.round(root)?, u: 0.0, v: 0.0 });
        }
    }
    Some(Truth::MISS)
}

/// `a·t² + 2b·t + c`: twice the value of the quadric along the ray, times a positive factor. It is negated if `a` is
/// negative, or if `a` is zero and `b` negative.
struct Polynomial<N> {
    a: N,
    b: N,
    c: N,
    /// `b² - a·c`.
    discriminant: N,
    kind: Kind,
}

/// How many roots there are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// `a` is zero. The root is [`Root::Greater`]: the other one goes to `-∞` as `a` goes to zero.
    Linear,
    Double,
    Two,
}

impl<N: Number> Polynomial<N> {
    /// The outer `None` is a doubt. The inner `None` is a polynomial without roots, or zero everywhere.
    fn of(shape: &Quadric, line: &Line<N>) -> Option<Option<Self>> {
        let [squares, products, linear] = N::vectors([shape.squares, shape.products, shape.linear]);
        let constant = N::new(shape.constant);
        let linear = linear.map(|coefficient| line.scaled(coefficient));
        let hessian = |v: &[N; 3]| hessian(&squares, &products, v);
        let (o, d) = (&line.origin, &line.dir);
        let curved = hessian(o);
        let gradient = [0, 1, 2].map(|axis| curved[axis].plus(&linear[axis]));
        let (a, b) = (dot(d, &hessian(d)), dot(d, &gradient));
        let constant = line.scaled(line.scaled(constant.plus(&constant)));
        let c = dot(o, &gradient).plus(&dot(&linear, o)).plus(&constant);

        let curvature = a.sign()?;
        let rising = if curvature.is_eq() { b.sign()? } else { curvature };
        let [a, b, c] = match rising {
            Ordering::Greater => [a, b, c],
            Ordering::Less => [a, b, c].map(|coefficient| coefficient.negated()),
            Ordering::Equal => return Some(None),
        };
        let discriminant = b.times(&b).minus(&a.times(&c));
        let kind = match discriminant.sign()? {
            Ordering::Less => return Some(None),
            _ if curvature.is_eq() => Kind::Linear,
            Ordering::Equal => Kind::Double,
            Ordering::Greater => Kind::Two,
        };
        Some(Some(Self { a, b, c, discriminant, kind }))
    }

    fn distinct_roots(&self) -> &'static [Root] {
        if self.kind == Kind::Two { &[Root::Lesser, Root::Greater] } else { &[Root::Greater] }
    }

    /// How both roots compare with the bound, in the order of [`Root`].
    fn roots_from(&self, bound: &Bound<N>) -> Option<[Ordering; 2]> {
        let (num, den) = match bound {
            Bound::Interval(t) if t.is_infinite() => return Some([0.0f32.partial_cmp(t)?; 2]),
            Bound::Interval(t) => (&N::new(*t), &N::new(1.0)),
            Bound::Plane { num, den } => (num, den),
        };
        // Half the slope at num / den, times den, and the value there, times den².
        let slope = self.a.times(num).plus(&self.b.times(den));
        let value = slope.times(num).plus(&self.b.times(num).plus(&self.c.times(den)).times(den));
        Some(match value.sign()? {
            Ordering::Less => [Ordering::Less, Ordering::Greater],
            Ordering::Equal => match slope.sign()? {
                Ordering::Less => [Ordering::Equal, Ordering::Greater],
                Ordering::Equal => [Ordering::Equal; 2],
                Ordering::Greater => [Ordering::Less, Ordering::Equal],
            },
            // The slope is not zero here, because there are roots.
            Ordering::Greater => [slope.sign()?.reverse(); 2],
        })
    }

    fn round(&self, root: Root) -> Option<f32> {
        let Self { a, b, c, discriminant, kind } = self;
        if *kind == Kind::Linear { c.negated().divided_by(&b.plus(b)) } else { N::root(a, b, c, discriminant, root) }
    }
}

impl Polynomial<Dyadic> {
    /// A root as a quotient. The divisor is positive.
    fn quotient(&self, root: Root) -> [Dyadic; 2] {
        let Self { a, b, c, discriminant, kind } = self;
        if *kind == Kind::Linear {
            return [c.negated(), b.plus(b)];
        }
        [Dyadic::root_numerator(a, b, discriminant, root), a.clone()]
    }
}
