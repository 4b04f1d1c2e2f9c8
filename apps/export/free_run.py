

def free_run(rows, rate_hz, state, start_s=0.0, p=PARAMETERS, every=1):
    """x of the equation by itself, at every so many rows. rows: inputs (num_rows x num_inputs) at rate_hz, cubic between
    them; state: position and speed at the first. Each sgn is located where it switches, and held there where neither
    side leads away (dry friction at rest)."""
    rows = np.asarray(rows, float).reshape(len(rows), NUM_INPUTS)
    slopes = np.gradient(rows, axis=0)
    slopes[2:-2] = (8 * (rows[3:-1] - rows[1:-3]) - (rows[4:] - rows[:-4])) / 12
    step = np.diff(rows, axis=0)
    cubic = np.stack([rows[:-1], slopes[:-1], 3 * step - 2 * slopes[:-1] - slopes[1:],
                      slopes[:-1] + slopes[1:] - 2 * step])

    def inputs(t):
        at = (t - start_s) * rate_hz
        i = min(max(int(at), 0), len(rows) - 2)
        a, b, c, d = cubic[:, i]
        return a + (at - i) * (b + (at - i) * (c + (at - i) * d))

    def beyond_hold(t, y, k, side):
        with_side = np.where(np.arange(NUM_SWITCHES) == k, side, sides)
        return (acceleration(p, t, y, inputs(t), with_side)[0] - hold(p, t, y, inputs(t), sides)[2 * k + 1])

    def rates(t, y):
        held = np.flatnonzero(sides == 0)
        if len(held):
            return [y[1], hold(p, t, y, inputs(t), sides)[2 * held[0] + 1]]
        return [y[1], acceleration(p, t, y, inputs(t), sides)[0]]

    def ends(k):
        def margin(t, y):
            if sides[k] != 0:
                return sides[k] * switches(p, t, y, inputs(t), sides)[k]
            return min(-beyond_hold(t, y, k, 1.0), beyond_hold(t, y, k, -1.0))
        margin.terminal, margin.direction = True, -1
        return margin

    def settle(t, y, k):
        above, below = beyond_hold(t, y, k, 1.0), beyond_hold(t, y, k, -1.0)
        if sides[k] == 0:  # of the two the one that no longer holds, by however little
            sides[k] = 1.0 if above > -below else -1.0
        elif CAN_HOLD[k] and (above > 0) == (below >= 0):
            sides[k] = 1.0 if above > 0 else -1.0
        elif not CAN_HOLD[k] or above > 0:
            sides[k] = -sides[k]
        else:
            sides[k], y[1] = 0.0, hold(p, t, y, inputs(t), sides)[2 * k]

    state = np.array(state, float)
    times = start_s + np.arange(0, len(rows), every) / rate_hz
    at_start = switches(p, start_s, state, inputs(start_s), np.zeros(NUM_SWITCHES))
    sides = np.where(at_start < 0, -1.0, 1.0)
    for k in np.flatnonzero(at_start == 0):
        settle(start_s, state, k)
    t, y, x = start_s, state, np.full(len(times), np.nan)
    scale = [1e-12 * max(abs(rows).max(initial=0.0), abs(state).max(), 1e-300)] * 2
    while True:
        wanted = np.flatnonzero(np.isnan(x))
        if not len(wanted):
            return x
        run = solve_ivp(rates, (t, times[-1] if len(times) > 1 else t), y, "DOP853", times[wanted],
                        events=[ends(k) for k in range(NUM_SWITCHES)] or None, rtol=1e-12, atol=scale,
                        max_step=1 / rate_hz)
        if run.status < 0:
            raise RuntimeError(run.message)
        for i, time, y in zip(wanted, run.t, run.y.T):
            x[i] = displacement(p, time, y, inputs(time), sides)[0]
        if run.status == 1:
            k = next(k for k in range(NUM_SWITCHES) if len(run.t_events[k]))
            t, y = run.t_events[k][-1], run.y_events[k][-1].copy()
            settle(t, y, k)


if __name__ == "__main__":
    file = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.abspath(__file__)), "free_run.csv")
    table = np.genfromtxt(file, delimiter=",", skip_header=1)
    every = int(RUN[4])
    expected = table[::every, -1]
    x = free_run(table[:, 1:-1], RUN[1], RUN[2:4], RUN[0], every=every)
    apart = np.abs(x - expected).max() / np.abs(expected).max()
    print("free run of %g s: at most %.3g of the largest x apart from Ardent's" % ((len(table) - 1) / RUN[1], apart))
    sys.exit(0 if apart <= 1e-8 else 1)
