

def free_run(rows, rate_hz, state, start_s=0.0, p=PARAMETERS, every=1):
    """Displacements of the equations by themselves, at every so many rows; of one body x alone. rows: inputs (num_rows x
    num_inputs) at rate_hz, cubic between them; state: at the first. Each sgn is located where it switches, and held
    there where neither side leads away (dry friction at rest)."""
    rows = np.asarray(rows, float).reshape(len(rows), NUM_INPUTS)
    slopes_of_rows = np.gradient(rows, axis=0)
    slopes_of_rows[2:-2] = (8 * (rows[3:-1] - rows[1:-3]) - (rows[4:] - rows[:-4])) / 12
    step = np.diff(rows, axis=0)
    cubic = np.stack([rows[:-1], slopes_of_rows[:-1], 3 * step - 2 * slopes_of_rows[:-1] - slopes_of_rows[1:],
                      slopes_of_rows[:-1] + slopes_of_rows[1:] - 2 * step])

    def inputs(t):
        at = (t - start_s) * rate_hz
        i = min(max(int(at), 0), len(rows) - 2)
        a, b, c, d = cubic[:, i]
        return a + (at - i) * (b + (at - i) * (c + (at - i) * d))

    def hold(t, y, given):
        """In the place of sides that are 0 those that keep each sgn's argument at zero, one that the others keep there
        staying 0; and by how much the rate of each argument changes with its own side."""
        full, pulls, held, u = given.copy(), np.zeros(NUM_SWITCHES), np.flatnonzero(given == 0), inputs(t)
        if not len(held):
            return full, pulls
        slope = slopes(p, t, y, u, given).reshape(NUM_SWITCHES, NUM_STATES + 1)[held]

        def paces(of):
            return slope @ np.append(rates(p, t, y, u, of), 1.0)

        at_zero = paces(given)
        a = np.array([paces(given + (np.arange(NUM_SWITCHES) == k)) - at_zero for k in held] + [-at_zero]).T
        pulls[held] = np.diag(a)
        for i in range(len(held)):
            if not abs(a[i, i]) > 1e-9 * abs(pulls[held[i]]):
                a[i], a[:, i] = 0.0, 0.0
                a[i, i] = 1.0
                continue
            for j in range(len(held)):
                if j != i:
                    a[j] -= a[j, i] / a[i, i] * a[i]
        full[held] = a[:, -1] / np.diag(a)
        return full, pulls

    def motion(t, y):
        return rates(p, t, y, inputs(t), hold(t, y, sides)[0])

    def ends(k):
        def margin(t, y):
            if sides[k] != 0:
                return sides[k] * switches(p, t, y, inputs(t), sides)[k]
            return 1.0 - abs(hold(t, y, sides)[0][k])
        margin.terminal, margin.direction = True, -1
        return margin

    def settle(t, y, k):
        """The side of switch k on which the motion goes on, and of those that are held and then no longer can be."""
        while True:
            before, sides[k] = sides[k], 0.0
            side, pull = (of[k] for of in hold(t, y, sides))
            if before != 0 and not pull < 0:
                sides[k] = -before
            elif before == 0 or abs(side) > 1:
                sides[k] = 1.0 if side > 0 else -1.0
            else:
                slope = slopes(p, t, y, inputs(t), sides).reshape(NUM_SWITCHES, NUM_STATES + 1)[k, :-1] * DRIVEN
                y -= switches(p, t, y, inputs(t), sides)[k] * slope / (slope @ slope)
            held = hold(t, y, sides)[0]
            loose = np.flatnonzero((sides == 0) & (np.abs(held) > 1))
            if not len(loose):
                return
            sides[loose[0]] = np.sign(held[loose[0]])

    state = np.array(state, float)
    times = start_s + np.arange(0, len(rows), every) / rate_hz
    at_start = switches(p, start_s, state, inputs(start_s), np.zeros(NUM_SWITCHES))
    sides = np.where(at_start < 0, -1.0, 1.0)
    for k in np.flatnonzero(at_start == 0):
        settle(start_s, state, k)
    t, y = start_s, state
    x = np.full((len(times), len(displacements(p, t, y, inputs(t), sides))), np.nan)
    scale = 1e-12 * max(abs(rows).max(initial=0.0), abs(state).max(), 1e-300)
    while True:
        wanted = np.flatnonzero(np.isnan(x[:, 0]))
        if not len(wanted):
            return x if x.shape[1] > 1 else x[:, 0]
        run = solve_ivp(motion, (t, times[-1] if len(times) > 1 else t), y, "DOP853", times[wanted],
                        events=[ends(k) for k in range(NUM_SWITCHES)] or None, rtol=1e-12, atol=scale,
                        max_step=1 / rate_hz)
        if run.status < 0:
            raise RuntimeError(run.message)
        for i, time, y in zip(wanted, run.t, np.transpose(run.y)):
            x[i] = displacements(p, time, y, inputs(time), sides)
        if run.status == 1:
            k = next(k for k in range(NUM_SWITCHES) if len(run.t_events[k]))
            t, y = run.t_events[k][-1], run.y_events[k][-1].copy()
            settle(t, y, k)


if __name__ == "__main__":
    file = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.abspath(__file__)), "free_run.csv")
    table = np.genfromtxt(file, delimiter=",", skip_header=1)
    every = int(RUN[2])
    expected = table[::every, 1 + NUM_INPUTS:]
    x = free_run(table[:, 1:1 + NUM_INPUTS], RUN[1], BEGIN, RUN[0], every=every).reshape(expected.shape)
    apart = (np.abs(x - expected).max(axis=0) / np.abs(expected).max(axis=0)).max()
    print("free run of %g s: at most %.3g of the largest x apart from Ardent's" % ((len(table) - 1) / RUN[1], apart))
    sys.exit(0 if apart <= 1e-8 else 1)
