// Loads a functional mock-up unit for co-simulation (FMI 2.0) and lets it run through the rows of free_run.csv:
//   importer equation.so GUID NUM_PARAMETERS NUM_STATES NUM_X free_run.csv
// Inputs go in with their derivatives in each row, those of the cubic through it. Prints how far each x is from the
// table's, over its largest.
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void *Unit;
static double table[400000][8];

static double slope(long n, long i, int c) {
  const long before = i > 0 ? i - 1 : 0, after = i + 1 < n ? i + 1 : i;
  if (i < 2 || i + 2 >= n) return (table[after][c] - table[before][c]) / (double)(after - before);
  return (8 * (table[i + 1][c] - table[i - 1][c]) - (table[i + 2][c] - table[i - 2][c])) / 12;
}

int main(int argc, char **argv) {
  if (argc != 7) return 2;
  void *library = dlopen(argv[1], RTLD_NOW);
  if (library == NULL) return fprintf(stderr, "%s\n", dlerror()), 2;
#define FUNCTION(type, name, ...) type (*name)(__VA_ARGS__) = (type(*)(__VA_ARGS__))dlsym(library, "fmi2" #name)
  FUNCTION(Unit, Instantiate, const char *, int, const char *, const char *, const void *, int, int);
  FUNCTION(int, SetupExperiment, Unit, int, double, double, int, double);
  FUNCTION(int, EnterInitializationMode, Unit);
  FUNCTION(int, ExitInitializationMode, Unit);
  FUNCTION(int, SetReal, Unit, const unsigned *, size_t, const double *);
  FUNCTION(int, GetReal, Unit, const unsigned *, size_t, double *);
  FUNCTION(int, SetRealInputDerivatives, Unit, const unsigned *, size_t, const int *, const double *);
  FUNCTION(int, DoStep, Unit, double, double, int);
  FUNCTION(void, FreeInstance, Unit);
  if (Instantiate("unit", 1, "{another}", "", NULL, 0, 0) != NULL) return 3;  // of another description
  Unit unit = Instantiate("unit", 1, argv[2], "", NULL, 0, 0);
  if (unit == NULL) return 3;

  FILE *file = fopen(argv[6], "r");
  static char line[4096];
  if (file == NULL || fgets(line, sizeof line, file) == NULL) return 2;
  const int num_x = atoi(argv[5]);
  int num_inputs = -num_x;
  for (const char *c = line; *c != 0; ++c) num_inputs += *c == ',';
  long n = 0;
  for (; fgets(line, sizeof line, file) != NULL && n < 400000; ++n) {
    char *at = line, *end;
    for (int c = 0; c < num_inputs + num_x + 1; ++c, at = strchr(at, ',') == NULL ? at : strchr(at, ',') + 1) {
      table[n][c] = strtod(at, &end);
      if (end == at) table[n][c] = NAN;
    }
  }
  const unsigned first_input = (unsigned)atoi(argv[3]), x = first_input + (unsigned)num_inputs + (unsigned)atoi(argv[4]);
  const double rate_hz = (double)(n - 1) / (table[n - 1][0] - table[0][0]), h = 1 / rate_hz;
  double most[8] = {0}, largest[8] = {0}, apart = 0.0;
  SetupExperiment(unit, 0, 0.0, table[0][0], 0, 0.0);
  EnterInitializationMode(unit), ExitInitializationMode(unit);
  for (long i = 0; i < n; ++i) {
    for (int c = 1; c <= num_inputs; ++c) {
      const unsigned r = first_input + (unsigned)c - 1, three[3] = {r, r, r};
      const int orders[3] = {1, 2, 3};
      if (SetReal(unit, &r, 1, &table[i][c]) != 0) return 4;
      if (i + 1 == n) continue;
      const double d = table[i + 1][c] - table[i][c], s = slope(n, i, c), e = slope(n, i + 1, c);
      const double derivatives[3] = {s / h, 2 * (3 * d - 2 * s - e) / (h * h), 6 * (s + e - 2 * d) / (h * h * h)};
      if (SetRealInputDerivatives(unit, three, 3, orders, derivatives) != 0) return 4;
    }
    for (int c = 0; c < num_x; ++c) {
      double here;
      const unsigned r = x + (unsigned)c;
      if (GetReal(unit, &r, 1, &here) != 0) return 4;
      const double expected = table[i][num_inputs + 1 + c];
      if (!isnan(expected)) most[c] = fmax(most[c], fabs(here - expected)), largest[c] = fmax(largest[c], fabs(expected));
    }
    if (i + 1 < n && DoStep(unit, table[0][0] + (double)i * h, h, 1) != 0) return 5;
  }
  FreeInstance(unit);
  for (int c = 0; c < num_x; ++c) apart = fmax(apart, most[c] / largest[c]);
  printf("%g\n", apart);
  return apart <= 1e-8 ? 0 : 1;
}
