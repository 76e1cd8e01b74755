//! Pictures at every scale and place: shadows stay, surfaces do not shade themselves, and a view that gives no picture
//! is refused.

use glam::{Affine3, Vec3};
use raylanes::geom::{Aabb, Quadric};
use raylanes::kernels::triangle::Woop;
use raylanes::tracer::{
    Camera, Geometry, Light, Mode, Picture, Scene, Shade, Shot, View, ViewError, World, picture_hits, shade,
};

use crate::worlds::{self, built_in_mesh, mesh, place};

const SIZE: u32 = 64;

/// A ball and a sphere of triangles on a square ground of this half width.
fn balls_on_ground(half_width: f32, at: Vec3) -> World {
    let square = mesh(
        vec![
            Vec3::new(-1.0, 0.0, -1.0),
            Vec3::new(1.0, 0.0, -1.0),
            Vec3::new(1.0, 0.0, 1.0),
            Vec3::new(-1.0, 0.0, 1.0),
        ],
        vec![[0, 2, 1], [0, 3, 2]],
    );
    let geometries = vec![
        Geometry::Mesh(square),
        Geometry::Quadric(Quadric::sphere(1.0)),
        Geometry::Mesh(built_in_mesh("sphere:2000")),
    ];
    let moved = |by: Vec3| Affine3::from_translation(by + at);
    let ground = moved(Vec3::ZERO) * Affine3::from_scale(Vec3::new(half_width, 1.0, half_width));
    let balls = [place(1, moved(Vec3::new(-1.5, 1.0, 0.0))), place(2, moved(Vec3::new(1.5, 1.0, 0.0)))];
    World::new(geometries, [place(0, ground)].into_iter().chain(balls).collect()).unwrap()
}

fn picture(world: World, at: Vec3, light: Light, shading: Shade) -> Picture {
    let camera = Camera::new(Vec3::new(0.0, 6.0, 14.0) + at, Vec3::new(0.0, 0.5, 0.0) + at, 40.0, SIZE, SIZE);
    let scene = Scene::<Woop<f32>>::new(world);
    let shot = Shot { camera, light, mode: Mode::Auto, width: SIZE, height: SIZE };
    shade(&scene, &shot, &picture_hits(&scene, &shot), shading)
}

fn brightness(picture: &Picture, x: u32, y: u32) -> f32 {
    picture.pixels()[(y * SIZE + x) as usize].element_sum() / 3.0
}

/// Pixels that differ from the pixels at the same place, and from all their neighbours, by more than a tenth. A shadow
/// or an outline may move by a pixel, since all coordinates are rounded.
fn wrong_pixels(expected: &Picture, got: &Picture) -> usize {
    let near = |x: u32, y: u32| {
        let around = |at: u32| at.saturating_sub(1)..=(at + 1).min(SIZE - 1);
        around(y).any(|y_near| {
            around(x).any(|x_near| (brightness(expected, x_near, y_near) - brightness(got, x, y)).abs() <= 0.1)
        })
    };
    (0..SIZE * SIZE).filter(|pixel| !near(pixel % SIZE, pixel / SIZE)).count()
}

/// Pixels that no light reaches.
fn dark_pixels(picture: &Picture) -> usize {
    (0..SIZE * SIZE).filter(|pixel| brightness(picture, pixel % SIZE, pixel / SIZE) < 0.3).count()
}

const LIGHT: Light = Light::Directional(Vec3::new(1.0, 1.0, 0.3));

#[test]
fn a_shadow_stays_on_the_largest_ground() {
    let expected = picture(balls_on_ground(1e3, Vec3::ZERO), Vec3::ZERO, LIGHT, Shade::Lambert);
    // The shadows of two balls, which cover a fortieth of the picture each.
    assert!((100..300).contains(&dark_pixels(&expected)), "{} pixels in shadow", dark_pixels(&expected));
    for half_width in [3e4, 1e6, 1e9] {
        let got = picture(balls_on_ground(half_width, Vec3::ZERO), Vec3::ZERO, LIGHT, Shade::Lambert);
        assert_eq!(wrong_pixels(&expected, &got), 0, "ground of {half_width:e}");
    }
}

#[test]
fn surfaces_far_from_the_origin_do_not_shade_themselves() {
    for shading in [Shade::Lambert, Shade::AmbientOcclusion] {
        for point in [false, true] {
            let at_place = |at: Vec3| {
                let light = if point { Light::Point(Vec3::new(5.0, 6.0, 3.0) + at) } else { LIGHT };
                picture(balls_on_ground(20.0, at), at, light, shading)
            };
            let expected = at_place(Vec3::ZERO);
            assert!(dark_pixels(&expected) < 500, "{shading:?}: {} dark pixels", dark_pixels(&expected));
            for at in [Vec3::X * 1e5, Vec3::Z * -1e5, Vec3::new(1e4, 1e4, -1e4)] {
                let wrong = wrong_pixels(&expected, &at_place(at));
                assert!(wrong <= 2, "{shading:?}, point light {point}, at {at}: {wrong} pixels");
            }
        }
    }
}

/// Also the inside of a bowl, where rounding along the surface brings a point below it.
#[test]
fn nothing_shades_itself_inside_a_sphere() {
    for scale in [1e-3, 1.0, 1e6] {
        for at in [Vec3::ZERO, Vec3::new(3e4, -1e4, 2e4) * scale] {
            let sphere = Geometry::Quadric(Quadric::sphere(1.0));
            let stretched = Vec3::new(1.0, 0.6, 1.5) * scale;
            let world = World::new(
                vec![sphere],
                vec![place(
                    0,
                    Affine3::from_scale_rotation_translation(
                        stretched,
                        glam::Quat::from_xyzw(0.1, 0.2, 0.3, 0.927_361_85),
                        at,
                    ),
                )],
            );
            let scene = Scene::<Woop<f32>>::new(world.unwrap());
            let camera = Camera::new(at, at + Vec3::new(0.3, 0.2, 1.0) * scale, 120.0, SIZE, SIZE);
            let shot = Shot { camera, light: Light::Point(at), mode: Mode::Auto, width: SIZE, height: SIZE };
            let got = shade(&scene, &shot, &picture_hits(&scene, &shot), Shade::Lambert);
            assert_eq!(dark_pixels(&got), 0, "scale {scale:e}, at {at}");
        }
    }
}

#[test]
fn a_light_of_any_length_has_a_direction() {
    let world = || balls_on_ground(20.0, Vec3::ZERO);
    let expected = picture(world(), Vec3::ZERO, LIGHT, Shade::Lambert);
    for length in [1e-30, 1e-20, 1e20, 1e38] {
        let light = Light::Directional(Vec3::new(1.0, 1.0, 0.3) * length);
        assert_eq!(wrong_pixels(&expected, &picture(world(), Vec3::ZERO, light, Shade::Lambert)), 0, "{length:e}");
    }
}

#[test]
fn views_that_give_no_picture_are_refused() {
    let world = || World::from(built_in_mesh("sphere:2000"));
    let view = View::around(&Aabb { lo: Vec3::splat(-1.0), hi: Vec3::ONE });
    assert_eq!(view.check(&world()), Ok(()));
    let check = |change: &dyn Fn(&mut View)| {
        let mut view = view;
        change(&mut view);
        view.check(&world()).unwrap_err().to_string()
    };
    assert_eq!(check(&|view| view.look_at = view.eye), ViewError::NoDirection(view.eye).to_string());
    assert_eq!(check(&|view| view.light = Light::Directional(Vec3::ZERO)), ViewError::NoLight(Vec3::ZERO).to_string());
    for far in [1e13, 1e38, f32::INFINITY, f32::NAN] {
        assert!(check(&|view| view.eye.x = far).contains("coordinate of the eye"), "{far}");
        assert!(check(&|view| view.look_at.y = far).contains("coordinate of look-at"), "{far}");
        assert!(
            check(&|view| view.light = Light::Point(Vec3::splat(far))).contains("coordinate of the light"),
            "{far}"
        );
    }
    assert!(check(&|view| view.eye.x = 1e9).contains("times the scene's size away"));
    // Every size that is accepted has all its pixels.
    let hits = |scale: f32| {
        let mesh = built_in_mesh("sphere:2000");
        let corners: Vec<_> = (0..mesh.len() as u32).flat_map(|one| mesh.triangle(one).vertices()).collect();
        let triangles = (0..mesh.len() as u32).map(|one| [3 * one, 3 * one + 1, 3 * one + 2]).collect();
        let world = World::from(worlds::mesh(corners.into_iter().map(|corner| corner * scale).collect(), triangles));
        let view = View::around(&Scene::<Woop<f32>>::new(world.clone()).bounds());
        view.check(&world).map(|()| {
            let camera = view.camera(SIZE, SIZE);
            let shot = Shot { camera, light: view.light, mode: Mode::Auto, width: SIZE, height: SIZE };
            picture_hits(&Scene::<Woop<f32>>::new(world), &shot).iter().filter(|hit| hit.mask).count()
        })
    };
    let expected = hits(1.0).unwrap();
    for scale in [1e-9, 1e-6, 1e6, 1e9, 1e11] {
        let got = hits(scale).unwrap();
        assert!(got.abs_diff(expected) <= expected / 100, "{scale:e}: {got} hits, {expected} at scale 1");
    }
    for scale in [1e-20, 1e-12, 1e13, 1e19] {
        assert!(hits(scale).is_err(), "{scale:e}");
    }
}
