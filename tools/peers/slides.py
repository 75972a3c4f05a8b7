"""Slides without a closed form, by scipy's DOP853 at 1e-13: numbers of `tests/cases/friction.md`."""

import numpy as np
from scipy.integrate import solve_ivp

G = 9.81


def solved(rate, span, start, event=None):
    return solve_ivp(rate, span, start, method="DOP853", rtol=1e-13, atol=1e-15, events=event, dense_output=True)


def popp():
    """A block of 1.3 kg on a spring of 2.1 N/m and a belt of 0.4 m/s: stick, slip, stick, slip, stick."""

    def rate(_, y):
        mu = 0.1 + 0.2 * np.exp((y[1] - 0.4) / 0.25)
        return [y[1], -2.1 / 1.3 * y[0] + mu * G]

    def slide(state):
        def caught(t, y):
            return 1.0 if t < 0.01 else y[1] - 0.4

        caught.terminal, caught.direction = True, 1
        # Just slower than the belt first.
        begun = solved(rate, (0, 0.02), state)
        rest = solved(rate, (0.02, 30), begun.y[:, -1], caught)
        return rest.y_events[0][0][0], rest.t_events[0][0]

    breaks = 0.3 * 1.3 * G / 2.1
    place, time = slide([0.0, 0.0])
    yield "stick", time
    for _ in range(2):
        time += (breaks - place) / 0.4
        yield "slip", time
        place, took = slide([breaks, 0.4])
        time += took
        yield "stick", time


def sideways():
    """A stone of sliding velocity (1, 2) on a slope of 0.2 with friction 0.35: where it stops."""
    pull, ratio, speed = 0.2 * G, 0.35 / 0.2, np.sqrt(5)
    stops = speed * (ratio - 1 / speed) / (pull * (ratio**2 - 1))

    # In the time that is left, exp(-s), the end is smooth.
    def rate(s, y):
        brake = 0.35 * G / np.hypot(y[2], y[3])
        return stops * np.exp(-s) * np.array([y[2], y[3], -pull - brake * y[2], -brake * y[3]])

    end = solved(rate, (0, 16), [0, 0, 1, 2]).y[:, -1]
    yield "x", end[0]
    yield "y", end[1]


def across():
    """A block of 0.7 kg under 2 N along x and 1.6 N/s t along y that breaks loose at 0.45 and slides with 0.3: its state at 2.5 s."""
    loose = np.sqrt((0.45 * 0.7 * G) ** 2 - 4) / 1.6
    pull = np.array([2 / 0.7, 1.6 * loose / 0.7])

    def rate(t, y):
        brake = 0.3 * G / np.hypot(y[2], y[3])
        return [y[2], y[3], 2 / 0.7 - brake * y[2], 1.6 * t / 0.7 - brake * y[3]]

    little = 1e-7
    v = pull * (1 - 0.3 * G / np.linalg.norm(pull)) * little
    end = solved(rate, (loose + little, 2.5), [0, 0, *v]).y[:, -1]
    yield from zip(["x", "y", "dot(x)", "dot(y)"], end)


for part in (popp, sideways, across):
    print(part.__name__, ", ".join(f"{name} {value:.12f}" for name, value in part()))
