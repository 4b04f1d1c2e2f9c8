
/* The equation by itself: Dormand-Prince 5(4), with every sgn located where it switches, and held there where neither
   side leads away (dry friction at rest). Compiled with -DEQUATION_MAIN it compares itself with free_run.csv. */

typedef double Cubic[4]; /* an input at tau seconds from now: u[0] + u[1] tau + u[2] tau^2 + u[3] tau^3 */
typedef struct {
  double p[NUM_PARAMETERS], t, state[2], largest[2];
  int side[NUM_SWITCHES + 1]; /* of each sgn: 1, -1; 0: held */
} Motion;

static void inputs_at(const Cubic *u, double tau, double *values) {
  for (int k = 0; k < NUM_INPUTS; ++k) values[k] = u[k][0] + tau * (u[k][1] + tau * (u[k][2] + tau * u[k][3]));
}

/* The acceleration, or where switch k is given what is beyond the one that holds it, on this side of it. */
static double accelerate(const Motion *m, const Cubic *u, double tau, const double *y, int k, double side) {
  double in[NUM_INPUTS + 1], sides[NUM_SWITCHES + 1], held[2 * NUM_SWITCHES + 1], value[1];
  inputs_at(u, tau, in);
  for (int i = 0; i < NUM_SWITCHES; ++i) sides[i] = i == k ? side : m->side[i];
  acceleration(m->p, m->t + tau, y, in, sides, value);
  if (k < 0) return value[0];
  hold(m->p, m->t + tau, y, in, sides, held);
  return value[0] - held[2 * k + 1];
}

static void rates(const Motion *m, const Cubic *u, double tau, const double *y, double *dydt) {
  double in[NUM_INPUTS + 1], held[2 * NUM_SWITCHES + 1];
  dydt[0] = y[1];
  for (int k = 0; k < NUM_SWITCHES; ++k)
    if (m->side[k] == 0) {
      inputs_at(u, tau, in);
      hold(m->p, m->t + tau, y, in, 0, held);
      dydt[1] = held[2 * k + 1];
      return;
    }
  dydt[1] = accelerate(m, u, tau, y, -1, 0.0);
}

/* From y at tau to `out` at tau + h; its error, 1 being what is allowed. */
static double step(const Motion *m, const Cubic *u, double tau, double h, double *out) {
  static const double c[7] = {0, 1 / 5., 3 / 10., 4 / 5., 8 / 9., 1, 1},
                      a[7][6] = {{0},
                                 {1 / 5.},
                                 {3 / 40., 9 / 40.},
                                 {44 / 45., -56 / 15., 32 / 9.},
                                 {19372 / 6561., -25360 / 2187., 64448 / 6561., -212 / 729.},
                                 {9017 / 3168., -355 / 33., 46732 / 5247., 49 / 176., -5103 / 18656.},
                                 {35 / 384., 0, 500 / 1113., 125 / 192., -2187 / 6784., 11 / 84.}},
                      e[7] = {71 / 57600.,      0,           -71 / 16695., 71 / 1920.,
                              -17253 / 339200., 22 / 525., -1 / 40.};
  double k[7][2], error = 0.0;
  for (int s = 0; s < 7; ++s) {
    for (int i = 0; i < 2; ++i) {
      double sum = 0.0;
      for (int j = 0; j < s; ++j) sum += a[s][j] * k[j][i];
      out[i] = m->state[i] + h * sum;
    }
    rates(m, u, tau + c[s] * h, out, k[s]);
  }
  for (int i = 0; i < 2; ++i) {
    double sum = 0.0;
    for (int s = 0; s < 7; ++s) sum += e[s] * k[s][i];
    error = fmax(error, fabs(h * sum) / (1e-12 * fmax(m->largest[i], fabs(out[i])) + 1e-300));
  }
  return isfinite(out[0]) && isfinite(out[1]) ? error : INFINITY;
}

/* The first switch that is beyond its side, or no longer held; -1: none. */
static int crossed(const Motion *m, const Cubic *u, double tau, const double *y) {
  double in[NUM_INPUTS + 1], g[NUM_SWITCHES + 1];
  inputs_at(u, tau, in);
  switches(m->p, m->t + tau, y, in, 0, g);
  for (int k = 0; k < NUM_SWITCHES; ++k)
    if (m->side[k] != 0 ? m->side[k] * g[k] < 0.0
                        : accelerate(m, u, tau, y, k, 1.0) > 0.0 || accelerate(m, u, tau, y, k, -1.0) < 0.0)
      return k;
  return -1;
}

/* The side of switch k on which the motion goes on. */
static void settle(Motion *m, const Cubic *u, double tau, int k) {
  const int before = m->side[k];
  const double above = accelerate(m, u, tau, m->state, k, 1.0), below = accelerate(m, u, tau, m->state, k, -1.0);
  if (before == 0 || (can_hold[k] && (above > 0.0) == (below >= 0.0))) {
    m->side[k] = above > 0.0 ? 1 : -1;
  } else if (!can_hold[k] || above > 0.0) {
    m->side[k] = -before;
  } else {
    double in[NUM_INPUTS + 1], held[2 * NUM_SWITCHES + 1];
    inputs_at(u, tau, in);
    hold(m->p, m->t + tau, m->state, in, 0, held);
    m->side[k] = 0;
    m->state[1] = held[2 * k];
  }
}

static void start(Motion *m, const Cubic *u) {
  double in[NUM_INPUTS + 1], g[NUM_SWITCHES + 1];
  inputs_at(u, 0.0, in);
  switches(m->p, m->t, m->state, in, 0, g);
  for (int i = 0; i < 2; ++i) m->largest[i] = fabs(m->state[i]);
  for (int k = 0; k < NUM_SWITCHES; ++k) m->side[k] = g[k] < 0.0 ? -1 : 1;
  for (int k = 0; k < NUM_SWITCHES; ++k)
    if (g[k] == 0.0) settle(m, u, 0.0, k);
}

/* Goes on by h seconds; 0: it cannot. */
static int advance(Motion *m, const Cubic *u, double h) {
  int num_events = 0;
  for (double tau = 0.0; tau < h;) {
    double d = h - tau, y[2], z[2];
    while (!(step(m, u, tau, d, y) <= 1.0))
      if ((d /= 2) < 1e-12 * h) return 0;
    int k = crossed(m, u, tau + d, y);
    const int is_last = k < 0 && d == h - tau;
    double low = 0.0;
    for (int i = 0; k >= 0 && i < 60; ++i) {
      const double middle = (low + d) / 2;
      (void)step(m, u, tau, middle, z);
      const int earlier = crossed(m, u, tau + middle, z);
      if (earlier < 0) {
        low = middle;
      } else {
        d = middle, k = earlier, y[0] = z[0], y[1] = z[1];
      }
    }
    tau = is_last ? h : tau + d;
    for (int i = 0; i < 2; ++i) m->state[i] = y[i], m->largest[i] = fmax(m->largest[i], fabs(y[i]));
    if (k >= 0) settle(m, u, tau, k);
    if (k >= 0 && ++num_events > 10000) return 0;
  }
  m->t += h;
  return 1;
}

static double slope(const double *u, long n, long i) { /* of every NUM_INPUTS-th number, a step */
  const long one = NUM_INPUTS, before = i > 0 ? i - 1 : 0, after = i + 1 < n ? i + 1 : i;
  if (i < 2 || i + 2 >= n) return (u[after * one] - u[before * one]) / (double)(after - before);
  return (8 * (u[(i + 1) * one] - u[(i - 1) * one]) - (u[(i + 2) * one] - u[(i - 2) * one])) / 12;
}

/* The inputs from row i to row i + 1, h seconds later, of n rows. */
static void cubics(const double *rows, long n, long i, double h, Cubic *u) {
  for (int k = 0; k < NUM_INPUTS; ++k) {
    const double a = rows[i * NUM_INPUTS + k], d = rows[(i + 1) * NUM_INPUTS + k] - a;
    const double s = slope(rows + k, n, i), e = slope(rows + k, n, i + 1);
    u[k][0] = a, u[k][1] = s / h, u[k][2] = (3 * d - 2 * s - e) / (h * h), u[k][3] = (s + e - 2 * d) / (h * h * h);
  }
}

#ifdef EQUATION_MAIN
int main(int argc, char **argv) {
  FILE *file = fopen(argc > 1 ? argv[1] : "free_run.csv", "r");
  if (file == NULL) return fprintf(stderr, "free_run.csv: cannot be read\n"), 2;
  static char line[1 << 16];
  long n = 0, room = 1024;
  double *rows = malloc((size_t)room * (NUM_INPUTS + 1) * sizeof(double)), *x = malloc((size_t)room * sizeof(double));
  if (fgets(line, sizeof line, file) == NULL) return 2;
  for (; fgets(line, sizeof line, file) != NULL; ++n) {
    if (n == room) {
      room *= 2;
      rows = realloc(rows, (size_t)room * (NUM_INPUTS + 1) * sizeof(double));
      x = realloc(x, (size_t)room * sizeof(double));
    }
    char *at = strchr(line, ',') + 1, *end; /* behind t */
    for (int k = 0; k < NUM_INPUTS; ++k, at = strchr(at, ',') + 1) rows[n * NUM_INPUTS + k] = strtod(at, NULL);
    x[n] = strtod(at, &end);
    if (end == at) x[n] = NAN;
  }
  fclose(file);
  Motion m;
  Cubic u[NUM_INPUTS + 1] = {{0}};
  double most = 0.0, largest = 0.0;
  memcpy(m.p, parameters, sizeof m.p);
  m.t = run[0], m.state[0] = run[2], m.state[1] = run[3];
  for (long i = 0; i < n; ++i) {
    if (i + 1 < n) cubics(rows, n, i, 1 / run[1], u);
    if (i == 0) start(&m, u);
    double here[1];
    displacement(m.p, m.t, m.state, rows + i * NUM_INPUTS, 0, here);
    if (!isnan(x[i])) most = fmax(most, fabs(here[0] - x[i])), largest = fmax(largest, fabs(x[i]));
    if (i + 1 < n && !advance(&m, u, 1 / run[1])) return fprintf(stderr, "the motion ends at t = %g s\n", m.t), 1;
  }
  printf("free run of %g s: at most %.3g of the largest x apart from Ardent's\n", (double)(n - 1) / run[1],
         most / largest);
  return most <= 1e-8 * largest ? 0 : 1;
}
#endif
