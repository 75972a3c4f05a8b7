//! Published data of the shipped scenes.

use hangtime::model::Shape;
use hangtime_cli::{Measure, Quantity, Task};

use hangtime_models::scenes;

#[test]
fn published_data_of_every_case_are_in_order_and_name_what_the_scene_has() {
    let scenes = scenes().iter();
    let cases: Vec<_> = scenes
        .flat_map(|scene| scene.published.iter().map(move |case| (scene, case)))
        .collect();
    // Two ski jumps; the pump track at three speeds, ridden passively and fastest.
    assert_eq!(cases.len(), 8);
    for (scene, case) in cases {
        let data = (case.data)().unwrap();
        let model = (scene.variants[0].model)();
        let declaration = model.declaration();
        let shapes = model.picture().unwrap().shapes.iter();
        let bodies = shapes
            .filter(|shape| matches!(shape, Shape::Point(_)))
            .count();
        assert!(data.points.len() > 10, "{}", case.name);
        assert!(data.points.is_sorted_by(|a, b| a.time < b.time));
        assert!(data.points.iter().all(|p| p.positions.len() == bodies));
        assert!(!data.curves.is_empty());
        for curve in &data.curves {
            assert!(curve.points.is_sorted_by(|a, b| a[0] < b[0]));
            assert!(curve.points.as_flattened().iter().all(|x| x.is_finite()));
            let unit = match curve.quantity {
                Quantity::Coordinate(i) => declaration.coordinates[i].unit.to_owned(),
                Quantity::Velocity(i) => format!("{}/s", declaration.coordinates[i].unit),
                Quantity::Output(i) => model.outputs()[i].unit.to_owned(),
                Quantity::Control(i) => declaration.controls[i].unit.to_owned(),
                Quantity::ContactForce(_) | Quantity::FrictionForce(_) => "N".to_owned(),
            };
            assert!(hangtime_units::convert(1.0, &unit, curve.unit).is_ok());
        }
        for value in case.values {
            let published = value.stated.or(data.value(value.measure));
            let known = value.reference.value();
            assert!(published.or(known).is_some(), "{value:?}");
        }
    }
}

#[test]
fn published_data_end_where_the_publication_says() {
    let scenes = scenes().iter();
    for case in scenes.flat_map(|scene| scene.published) {
        let data = (case.data)().unwrap();
        let end = data.value(Measure::FinalTime).unwrap();
        if let Task::Simulate { horizon } = case.task {
            // The ski jumps are plotted up to a horizontal position of 55 m.
            assert!(end <= horizon + 1e-9, "{}: {end}", case.name);
        } else {
            let y = data.value(Measure::Final(Quantity::Coordinate(0)));
            assert!((y.unwrap() - std::f64::consts::TAU).abs() < 1e-12);
        }
    }
}
