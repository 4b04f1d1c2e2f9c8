
/* FMI 2.0 for co-simulation, its types and functions as the standard has them. Value references: parameters, inputs,
   then the states and displacements. Inputs are polynomials of third degree in a step where their derivatives are given. */

#define EXPORTED __attribute__((visibility("default")))
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef unsigned int Reference;
enum { FIRST_INPUT = NUM_PARAMETERS, FIRST_OUTPUT = NUM_PARAMETERS + NUM_INPUTS };
typedef struct {
  Motion motion;
  Cubic u[NUM_INPUTS + 1]; /* derivatives, not yet over their factorials */
  int is_started;
} Instance;

static void reset(Instance *i) {
  memset(i, 0, sizeof *i);
  memcpy(i->motion.p, parameters, sizeof i->motion.p);
  memcpy(i->motion.state, begin, sizeof i->motion.state);
  i->motion.t = run[0];
}

EXPORTED const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORTED const char *fmi2GetVersion(void) { return "2.0"; }
EXPORTED void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                               const void *callbacks, int visible, int logging) {
  (void)name, (void)resources, (void)callbacks, (void)visible, (void)logging;
  Instance *i = type == 1 && strcmp(guid, GUID) == 0 ? malloc(sizeof(Instance)) : NULL;
  if (i != NULL) reset(i);
  return i;
}
EXPORTED void fmi2FreeInstance(void *i) { free(i); }
EXPORTED fmi2Status fmi2Reset(void *i) { return reset(i), fmi2OK; }
EXPORTED fmi2Status fmi2SetupExperiment(void *i, int has_tolerance, double tolerance, double start_s, int has_stop,
                                        double stop_s) {
  (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop_s;
  ((Instance *)i)->motion.t = start_s;
  return fmi2OK;
}

static double *place(Instance *i, Reference r) {
  if (r < FIRST_INPUT) return &i->motion.p[r];
  if (r < FIRST_OUTPUT) return &i->u[r - FIRST_INPUT][0];
  return r < FIRST_OUTPUT + NUM_STATES ? &i->motion.state[r - FIRST_OUTPUT] : NULL;
}
EXPORTED fmi2Status fmi2GetReal(void *instance, const Reference *r, size_t n, double *values) {
  Instance *i = instance;
  for (size_t k = 0; k < n; ++k) {
    const double *at = place(i, r[k]);
    double in[NUM_INPUTS + 1], x[NUM_X];
    for (int j = 0; j < NUM_INPUTS; ++j) in[j] = i->u[j][0];
    displacements(i->motion.p, i->motion.t, i->motion.state, in, 0, x);
    if (at == NULL && r[k] >= FIRST_OUTPUT + NUM_STATES + NUM_X) return fmi2Error;
    values[k] = at != NULL ? *at : x[r[k] - FIRST_OUTPUT - NUM_STATES];
  }
  return fmi2OK;
}
EXPORTED fmi2Status fmi2SetReal(void *instance, const Reference *r, size_t n, const double *values) {
  Instance *i = instance;
  for (size_t k = 0; k < n; ++k) {
    if (place(i, r[k]) == NULL || (i->is_started && r[k] >= FIRST_OUTPUT)) return fmi2Error;
    *place(i, r[k]) = values[k];
    if (r[k] >= FIRST_INPUT && r[k] < FIRST_OUTPUT) memset(&i->u[r[k] - FIRST_INPUT][1], 0, 3 * sizeof(double));
  }
  return fmi2OK;
}
EXPORTED fmi2Status fmi2SetRealInputDerivatives(void *instance, const Reference *r, size_t n, const int *order,
                                                const double *values) {
  for (size_t k = 0; k < n; ++k) {
    if (r[k] < FIRST_INPUT || r[k] >= FIRST_OUTPUT || order[k] < 1 || order[k] > 3) return fmi2Error;
    ((Instance *)instance)->u[r[k] - FIRST_INPUT][order[k]] = values[k];
  }
  return fmi2OK;
}
EXPORTED fmi2Status fmi2DoStep(void *instance, double t, double h, int no_set_state_before) {
  (void)no_set_state_before;
  Instance *i = instance;
  Cubic u[NUM_INPUTS + 1];
  memcpy(u, i->u, sizeof u);
  for (int k = 0; k < NUM_INPUTS; ++k) u[k][2] /= 2, u[k][3] /= 6;
  i->motion.t = t;
  if (!i->is_started) start(&i->motion, (const Cubic *)u);
  i->is_started = 1;
  if (!advance(&i->motion, (const Cubic *)u, h)) return fmi2Error;
  for (int k = 0; k < NUM_INPUTS; ++k) { /* what was given holds from the begin of one step to its end */
    i->u[k][0] = u[k][0] + h * (u[k][1] + h * (u[k][2] + h * u[k][3]));
    i->u[k][1] = i->u[k][2] = i->u[k][3] = 0.0;
  }
  return fmi2OK;
}

#define OF_NONE(type, name) \
  EXPORTED fmi2Status fmi2Get##name(void *i, const Reference *r, size_t n, type *v) { return (void)i, (void)r, (void)v, n == 0 ? fmi2OK : fmi2Error; } \
  EXPORTED fmi2Status fmi2Set##name(void *i, const Reference *r, size_t n, const type *v) { return (void)i, (void)r, (void)v, n == 0 ? fmi2OK : fmi2Error; }
OF_NONE(int, Integer)
OF_NONE(int, Boolean)
OF_NONE(const char *, String)
EXPORTED fmi2Status fmi2SetDebugLogging(void *i, int on, size_t n, const char *const *categories) {
  return (void)i, (void)on, (void)n, (void)categories, fmi2OK;
}
EXPORTED fmi2Status fmi2EnterInitializationMode(void *i) { return (void)i, fmi2OK; }
EXPORTED fmi2Status fmi2ExitInitializationMode(void *i) { return (void)i, fmi2OK; }
EXPORTED fmi2Status fmi2Terminate(void *i) { return (void)i, fmi2OK; }
EXPORTED fmi2Status fmi2CancelStep(void *i) { return (void)i, fmi2Error; }
/* What the description says is not there; whatever the arguments are, none is looked at. */
#define NOT_THERE(name) \
  EXPORTED fmi2Status name(void *i) { return (void)i, fmi2Error; }
NOT_THERE(fmi2GetRealOutputDerivatives)
NOT_THERE(fmi2GetFMUstate)
NOT_THERE(fmi2SetFMUstate)
NOT_THERE(fmi2FreeFMUstate)
NOT_THERE(fmi2SerializedFMUstateSize)
NOT_THERE(fmi2SerializeFMUstate)
NOT_THERE(fmi2DeSerializeFMUstate)
NOT_THERE(fmi2GetDirectionalDerivative)
NOT_THERE(fmi2GetStatus)
NOT_THERE(fmi2GetRealStatus)
NOT_THERE(fmi2GetIntegerStatus)
NOT_THERE(fmi2GetBooleanStatus)
NOT_THERE(fmi2GetStringStatus)
