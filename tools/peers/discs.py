"""A thin disc on a rough plane, by Newton's and Euler's equations and scipy's DOP853 at 1e-13: numbers of `tests/cases/friction.md`.

The state is (center, its velocity, axis n of the disc, angular momentum L about the center), without angles, multipliers or contact law. The lowest point
of the rim is r u below the center, u the direction in the disc that points up most; what is solved for at each time is the force there: that which keeps the
material velocity of the point zero (rolling), or that along z with mu N against the sliding velocity (sliding), N from the vertical velocity.
"""

import numpy as np
from scipy.integrate import solve_ivp

M, R, G = 0.8, 0.25, 9.81
AXIAL, ACROSS = M * R**2 / 2, M * R**2 / 4
UP = np.array([0.0, 0.0, 1.0])


def frame(heading, lean):
    """Direction ahead, direction up in the disc, axis."""
    h = np.array([np.cos(heading), np.sin(heading), 0.0])
    u = np.array([-np.sin(heading) * np.sin(lean), np.cos(heading) * np.sin(lean), np.cos(lean)])
    return h, u, np.cross(h, u)


def upward(n):
    u = UP - n[2] * n
    return u / np.linalg.norm(u)


def spin_of(n, L):
    return L / ACROSS + (1 / AXIAL - 1 / ACROSS) * (L @ n) * n


def slip(y):
    """Velocity of the lowest material point."""
    v, n, L = y[3:6], y[6:9], y[9:12]
    return v + np.cross(spin_of(n, L), -R * upward(n))


def rates(y, mu):
    """The derivative of the state, and the force at the ground; `mu` is None where the disc rolls."""
    v, n, L = y[3:6], y[6:9], y[9:12]
    omega = spin_of(n, L)
    rho = -R * upward(n)
    dn = np.cross(omega, n)
    size = np.sqrt(1 - n[2] ** 2)
    numerator, d_numerator = UP - n[2] * n, -dn[2] * n - n[2] * dn
    d_size = -n[2] * dn[2] / size
    d_rho = -R * (d_numerator / size - numerator * d_size / size**2)
    coupling = 1 / AXIAL - 1 / ACROSS

    def acceleration(force):
        """Of the lowest material point, along the path of contacts."""
        torque = np.cross(rho, force)
        d_omega = torque / ACROSS + coupling * ((torque @ n) * n + (L @ n) * dn)
        return force / M - G * UP + np.cross(d_omega, rho) + np.cross(omega, d_rho)

    free = acceleration(np.zeros(3))
    matrix = np.column_stack([acceleration(e) - free for e in np.eye(3)])
    if mu is None:
        force = np.linalg.solve(matrix, -free)
    else:
        w = slip(y)[:2]
        direction = np.append(-mu * w / np.hypot(*w), 1.0)
        force = direction * (-free[2] / (matrix @ direction)[2])
    return np.concatenate([v, force / M - G * UP, dn, np.cross(rho, force)]), force


def start(lean, heading_rate, lean_rate, spin_rate, slides):
    h, u, n = frame(0.0, lean)
    omega = heading_rate * UP - lean_rate * h + spin_rate * n
    v = np.cross(omega, R * u)
    v[:2] += slides
    L = ACROSS * omega + (AXIAL - ACROSS) * (omega @ n) * n
    return np.concatenate([R * u * [0, 0, 1], v, n, L])


def integrate(y, begin, end, mu, least=None):
    event = None
    if least is not None:

        def event(_, y):
            return np.hypot(*slip(y)[:2]) - least

        event.terminal = True
    run = solve_ivp(
        lambda _, y: rates(y, mu)[0], (begin, end), y, method="DOP853", rtol=1e-13, atol=1e-14, max_step=0.01, events=event
    )
    return run.t[-1], run.y[:, -1], run.status == 1


def shown(name, time, y):
    n = y[6:9]
    print(f"{name}: t = {time:.12f}, x = {y[0]:.12f}, y = {y[1]:.12f}, lean = {np.arcsin(n[2]):.12f}, v_x = {y[3]:.12f}, v_y = {y[4]:.12f}")


def main():
    y = start(1.1, 9.0, 0.4, -8.5, [0.0, 0.0])
    time, y, _ = integrate(y, 0.0, 1.5, None)
    shown("Euler's disc", time, y)
    mu = 0.4
    y = start(0.3, 12.0, 0.0, -4.0, [0.4, -0.7])
    # At the end of a slide its speed falls evenly: the time that is left follows from two speeds.
    (earlier, _, _), (time, y, stops) = [integrate(y, 0.0, 0.8, mu, least) for least in (1e-6, 1e-8)]
    assert stops
    force = rates(y, None)[1]
    assert np.hypot(*force[:2]) < mu * force[2], "it would go on sliding"
    shown("coin at the end of its slide", time + (time - earlier) / 99, y)
    time, y, _ = integrate(y, time, 0.8, None)
    shown("coin", time, y)


if __name__ == "__main__":
    main()
