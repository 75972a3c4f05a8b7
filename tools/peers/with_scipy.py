"""scipy's solve_ivp: one run from switch to switch, with events that stop it and the next mode by hand."""

from scipy.integrate import solve_ivp

from rides import G, PUMP_TRACKS, SKI_JUMPS
from timing import fastest

TOLERANCES = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12]


def until(event):
    """An event that ends a run where it falls through zero."""
    event.terminal, event.direction = True, -1
    return event


def integrate(fun, start, x, end, method, tolerance, event=None):
    """Time and state at the event or at the end, and whether it was the event."""
    run = solve_ivp(fun, (start, end), x, method=method, rtol=max(tolerance, 1e-13), atol=tolerance, events=event)
    if not run.success:
        raise RuntimeError(run.message)
    return run.t[-1], run.y[:, -1], run.status == 1


def jump(ride, method, tolerance):
    """Slide, flight, slide."""

    def slide(surface):
        def fun(_, x):
            _, slope, bend = surface(x[0])
            return x[1], -slope * (G + bend * x[1] ** 2) / (1 + slope**2)

        return fun

    leaves = until(lambda _, x: G + ride.table(x[0])[2] * x[1] ** 2)
    time, (y, v), left = integrate(slide(ride.table), 0.0, (ride.start, 0.0), ride.horizon, method, tolerance, leaves)
    height, slope, _ = ride.table(y)
    if not left:
        return y, height
    flight = (lambda _, x: (x[2], x[3], 0.0, -G))
    lands = until(lambda _, x: x[1] - ride.slope(x[0])[0])
    time, (y, z, vy, vz), landed = integrate(flight, time, (y, height, v, slope * v), ride.horizon, method, tolerance, lands)
    if not landed:
        return y, z
    _, slope, _ = ride.slope(y)
    v = (vy + slope * vz) / (1 + slope**2)
    _, (y, _), _ = integrate(slide(ride.slope), time, (y, v), ride.horizon, method, tolerance)
    return y, ride.slope(y)[0]


def ride_on_track(ride, method, tolerance):
    """On the track and in the air by turns."""
    track = ride.track

    def pushed(y, v):
        return G + track(y)[2] * v**2

    def on_track(_, x):
        return x[1], -track(x[0])[1] * pushed(x[0], x[1])

    def in_air(_, x):
        return x[2], x[3], 0.0, -pushed(x[0], x[2])

    leaves = until(lambda _, x: pushed(x[0], x[1]))
    lands = until(lambda _, x: x[1])
    time, y, v = 0.0, 0.0, ride.speed
    while True:
        if pushed(y, v) > 0:
            time, (y, v), switched = integrate(on_track, time, (y, v), ride.horizon, method, tolerance, leaves)
            if not switched:
                return y, 0.0, ride.length
        time, (y, s, v, fall), switched = integrate(
            in_air, time, (y, 0.0, v, 0.0), ride.horizon, method, tolerance, lands
        )
        if not switched:
            return y, s, ride.length
        v += track(y)[1] * fall


def points(wanted):
    """(study, curve, settings, CPU seconds, coordinates at the end) of every run of the studies that are wanted."""
    for rides, run in ((SKI_JUMPS, jump), (PUMP_TRACKS, ride_on_track)):
        for ride in filter(lambda ride: wanted(ride.study), rides):
            for method in ("DOP853", "Radau"):
                for tolerance in TOLERANCES:
                    seconds, end = fastest(lambda: run(ride, method, tolerance))
                    yield ride.study, f"scipy {method}", f"rtol = atol = {tolerance:g}", seconds, end
