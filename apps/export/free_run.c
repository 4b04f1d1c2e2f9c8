
/* The equation by itself: Dormand-Prince 5(4), with every sgn located where it switches, and held there where neither
   side leads away (dry friction at rest). Compiled with -DEQUATION_MAIN it compares itself with free_run.csv. */

typedef double Cubic[4]; /* an input at tau seconds from now: u[0] + u[1] tau + u[2] tau^2 + u[3] tau^3 */
typedef struct {
  double p[NUM_PARAMETERS], t, state[NUM_STATES], largest[NUM_STATES];
  double side[NUM_SWITCHES + 1]; /* of each sgn: 1, -1; 0: held */
} Motion;

static void inputs_at(const Cubic *u, double tau, double *values) {
  for (int k = 0; k < NUM_INPUTS; ++k) values[k] = u[k][0] + tau * (u[k][1] + tau * (u[k][2] + tau * u[k][3]));
}

/* The rates of the states, and of the arguments of those switches that are held. */
static void paces(const Motion *m, double t, const double *y, const double *in, const double *sides, const int *held,
                  int n, double *rate, double *pace) {
  double slope[NUM_SWITCHES * (NUM_STATES + 1) + 1];
  rates(m->p, t, y, in, sides, rate);
  if (n > 0) slopes(m->p, t, y, in, sides, slope);
  for (int k = 0; k < n; ++k) {
    const double *row = slope + held[k] * (NUM_STATES + 1);
    pace[k] = row[NUM_STATES];
    for (int j = 0; j < NUM_STATES; ++j) pace[k] += row[j] * rate[j];
  }
}

/* In the place of sides that are 0 those that keep each sgn's argument at zero, one that the others keep there staying
   0; the rates with them; and by how much the rate of each argument changes with its own side. */
static void hold(const Motion *m, const Cubic *u, double tau, const double *y, double *sides, double *rate,
                 double *pulls) {
  double in[NUM_INPUTS + 1], at_zero[NUM_SWITCHES + 1], pace[NUM_SWITCHES + 1];
  double a[NUM_SWITCHES + 1][NUM_SWITCHES + 1];
  int held[NUM_SWITCHES + 1] = {0}, n = 0;
  inputs_at(u, tau, in);
  for (int k = 0; k < NUM_SWITCHES; ++k)
    if (sides[k] == 0) held[n++] = k;
  paces(m, m->t + tau, y, in, sides, held, n, rate, at_zero);
  if (n == 0) return;
  for (int k = 0; k < n; ++k) {
    sides[held[k]] = 1;
    paces(m, m->t + tau, y, in, sides, held, n, rate, pace);
    sides[held[k]] = 0;
    for (int j = 0; j < n; ++j) a[j][k] = pace[j] - at_zero[j];
    a[k][n] = -at_zero[k];
    pulls[held[k]] = a[k][k];
  }
  for (int i = 0; i < n; ++i) {
    const int is_known = !(fabs(a[i][i]) > 1e-9 * fabs(pulls[held[i]]));
    for (int j = 0; j <= n && is_known; ++j) a[i][j] = 0.0;
    for (int j = 0; j < n && is_known; ++j) a[j][i] = 0.0;
    if (is_known) a[i][i] = 1.0;
    for (int j = 0; j < n && !is_known; ++j) {
      const double factor = a[j][i] / a[i][i];
      for (int k = 0; k <= n && j != i; ++k) a[j][k] -= factor * a[i][k];
    }
  }
  for (int k = 0; k < n; ++k) sides[held[k]] = a[k][n] / a[k][k];
  rates(m->p, m->t + tau, y, in, sides, rate);
}

/* The rates with every held switch kept at zero; the sides that keep it. */
static void move(const Motion *m, const Cubic *u, double tau, const double *y, double *rate, double *sides) {
  double pulls[NUM_SWITCHES + 1];
  memcpy(sides, m->side, sizeof m->side);
  hold(m, u, tau, y, sides, rate, pulls);
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
  double k[7][NUM_STATES], sides[NUM_SWITCHES + 1], error = 0.0;
  for (int s = 0; s < 7; ++s) {
    for (int i = 0; i < NUM_STATES; ++i) {
      double sum = 0.0;
      for (int j = 0; j < s; ++j) sum += a[s][j] * k[j][i];
      out[i] = m->state[i] + h * sum;
    }
    move(m, u, tau + c[s] * h, out, k[s], sides);
  }
  for (int i = 0; i < NUM_STATES; ++i) {
    double sum = 0.0;
    for (int s = 0; s < 7; ++s) sum += e[s] * k[s][i];
    error = fmax(error, fabs(h * sum) / (1e-12 * fmax(m->largest[i], fabs(out[i])) + 1e-300));
  }
  for (int i = 0; i < NUM_STATES; ++i)
    if (!isfinite(out[i])) return INFINITY;
  return error;
}

/* The first switch that is beyond its side, or no longer held; -1: none. */
static int crossed(const Motion *m, const Cubic *u, double tau, const double *y) {
  double in[NUM_INPUTS + 1], g[NUM_SWITCHES + 1], sides[NUM_SWITCHES + 1], rate[NUM_STATES];
  inputs_at(u, tau, in);
  switches(m->p, m->t + tau, y, in, 0, g);
  move(m, u, tau, y, rate, sides);
  for (int k = 0; k < NUM_SWITCHES; ++k)
    if (m->side[k] != 0 ? m->side[k] * g[k] < 0.0 : fabs(sides[k]) > 1.0) return k;
  return -1;
}

/* The side of switch k on which the motion goes on. */
static void decide(Motion *m, const Cubic *u, double tau, int k) {
  double sides[NUM_SWITCHES + 1], rate[NUM_STATES], pulls[NUM_SWITCHES + 1] = {0};
  const double before = m->side[k];
  memcpy(sides, m->side, sizeof sides);
  sides[k] = 0;
  hold(m, u, tau, m->state, sides, rate, pulls);
  if (before != 0 && !(pulls[k] < 0.0)) {
    m->side[k] = -before;
  } else if (before == 0 || fabs(sides[k]) > 1.0) {
    m->side[k] = sides[k] > 0.0 ? 1 : -1;
  } else {
    double in[NUM_INPUTS + 1], g[NUM_SWITCHES + 1], slope[NUM_SWITCHES * (NUM_STATES + 1) + 1], squares = 0.0;
    const double *row = slope + k * (NUM_STATES + 1);
    inputs_at(u, tau, in);
    switches(m->p, m->t + tau, m->state, in, 0, g);
    slopes(m->p, m->t + tau, m->state, in, sides, slope);
    for (int j = 0; j < NUM_STATES; ++j) squares += driven[j] * row[j] * row[j];
    for (int j = 0; j < NUM_STATES; ++j) m->state[j] -= g[k] * driven[j] * row[j] / squares;
    m->side[k] = 0;
  }
}

/* The same, and of those that are held and then no longer can be. */
static void settle(Motion *m, const Cubic *u, double tau, int k) {
  double sides[NUM_SWITCHES + 1], rate[NUM_STATES];
  for (int loose = 0; loose >= 0;) {
    decide(m, u, tau, k);
    move(m, u, tau, m->state, rate, sides);
    loose = -1;
    for (int i = NUM_SWITCHES - 1; i >= 0; --i)
      if (m->side[i] == 0 && fabs(sides[i]) > 1.0) loose = i;
    if (loose >= 0) m->side[loose] = sides[loose] > 0.0 ? 1 : -1;
  }
}

static void start(Motion *m, const Cubic *u) {
  double in[NUM_INPUTS + 1], g[NUM_SWITCHES + 1];
  inputs_at(u, 0.0, in);
  switches(m->p, m->t, m->state, in, 0, g);
  for (int i = 0; i < NUM_STATES; ++i) m->largest[i] = fabs(m->state[i]);
  for (int k = 0; k < NUM_SWITCHES; ++k) m->side[k] = g[k] < 0.0 ? -1 : 1;
  for (int k = 0; k < NUM_SWITCHES; ++k)
    if (g[k] == 0.0) settle(m, u, 0.0, k);
}

/* Goes on by h seconds; 0: it cannot. */
static int advance(Motion *m, const Cubic *u, double h) {
  int num_events = 0;
  for (double tau = 0.0; tau < h;) {
    double d = h - tau, y[NUM_STATES], z[NUM_STATES];
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
        d = middle, k = earlier;
        memcpy(y, z, sizeof y);
      }
    }
    tau = is_last ? h : tau + d;
    for (int i = 0; i < NUM_STATES; ++i) m->state[i] = y[i], m->largest[i] = fmax(m->largest[i], fabs(y[i]));
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
  double *rows = malloc((size_t)room * (NUM_INPUTS + 1) * sizeof(double));
  double *x = malloc((size_t)room * NUM_X * sizeof(double));
  if (fgets(line, sizeof line, file) == NULL) return 2;
  for (; fgets(line, sizeof line, file) != NULL; ++n) {
    if (n == room) {
      room *= 2;
      rows = realloc(rows, (size_t)room * (NUM_INPUTS + 1) * sizeof(double));
      x = realloc(x, (size_t)room * NUM_X * sizeof(double));
    }
    char *at = line, *end;
    for (int k = 0; k < NUM_INPUTS + NUM_X; ++k) {
      at = strchr(at, ',') + 1; /* behind t, and what was read */
      const double value = strtod(at, &end);
      if (k < NUM_INPUTS)
        rows[n * NUM_INPUTS + k] = value;
      else
        x[n * NUM_X + k - NUM_INPUTS] = end == at ? NAN : value;
    }
  }
  fclose(file);
  Motion m;
  Cubic u[NUM_INPUTS + 1] = {{0}};
  double most[NUM_X] = {0}, largest[NUM_X] = {0}, apart = 0.0;
  memcpy(m.p, parameters, sizeof m.p);
  memcpy(m.state, begin, sizeof m.state);
  m.t = run[0];
  for (long i = 0; i < n; ++i) {
    if (i + 1 < n) cubics(rows, n, i, 1 / run[1], u);
    if (i == 0) start(&m, u);
    double here[NUM_X];
    displacements(m.p, m.t, m.state, rows + i * NUM_INPUTS, 0, here);
    for (int k = 0; k < NUM_X; ++k) {
      const double expected = x[i * NUM_X + k];
      if (!isnan(expected)) most[k] = fmax(most[k], fabs(here[k] - expected)), largest[k] = fmax(largest[k], fabs(expected));
    }
    if (i + 1 < n && !advance(&m, u, 1 / run[1])) return fprintf(stderr, "the motion ends at t = %g s\n", m.t), 1;
  }
  for (int k = 0; k < NUM_X; ++k) apart = fmax(apart, most[k] / largest[k]);
  printf("free run of %g s: at most %.3g of the largest x apart from Ardent's\n", (double)(n - 1) / run[1], apart);
  return apart <= 1e-8 ? 0 : 1;
}
#endif
