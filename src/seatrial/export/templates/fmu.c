/* The boat of ${name}.h as a Functional Mock-up Unit: FMI 2.0, co-simulation. Written by ${source}.
 *
 * The types below are those of the standard (FMI 2.0.4, 2.1.4 and 2.1.5), so that nothing else is needed.
 * As source code in another program, define FMI2_FUNCTION_PREFIX as in the standard.
 */
#include <stdlib.h>
#include "${name}.h"

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef char fmi2Byte;
typedef const char* fmi2String;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef int fmi2StatusKind;
typedef struct {
  void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
  void* (*allocateMemory)(size_t, size_t);
  void (*freeMemory)(void*);
  void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
  fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

#ifdef FMI2_FUNCTION_PREFIX
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define FMI(function) JOIN(FMI2_FUNCTION_PREFIX, function)
#elif defined _WIN32
#define FMI(function) __declspec(dllexport) function
#else
#define FMI(function) function
#endif

enum { COMMANDS = ${NAME}_COMMANDS, SCALES = ${SCALES}, STATES = ${NAME}_STATES, FORCES = ${NAME}_FORCES };
enum { SCALE = COMMANDS, START = SCALE + SCALES, STATE = START + STATES, FORCE = STATE + STATES };

/* An instance: real[] is every variable by its value reference. */
typedef struct {
  ${name}_boat boat;
  double real[FORCE + FORCES];
  double given[COMMANDS]; /* the command that holds */
  char* name;
  fmi2CallbackFunctions callback;
} Instance;

static fmi2Status complain(const Instance* own, const char* words) {
  if (own->callback.logger) {
    own->callback.logger(own->callback.componentEnvironment, own->name, fmi2Error, "logStatusError", words);
  }
  return fmi2Error;
}

/* The boat's state as variables. */
static void show(Instance* own) {
  double thrust[${NAME}_ACTUATORS];
  int k;
  ${name}_thrust(&own->boat, thrust);
  ${name}_mix(thrust, own->real + FORCE);
  for (k = 0; k < STATES; ++k) own->real[STATE + k] = own->boat.x[k];
}

static void restart(Instance* own) {
  memset(own->real, 0, sizeof own->real);
  memset(own->given, 0, sizeof own->given);
  ${name}_reset(&own->boat);
${scale_starts}  show(own);
}

fmi2String FMI(fmi2GetTypesPlatform)(void) { return "default"; }
fmi2String FMI(fmi2GetVersion)(void) { return "2.0"; }

fmi2Component FMI(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                   const fmi2CallbackFunctions* callback, fmi2Boolean visible, fmi2Boolean logging) {
  Instance* own;
  (void)resources, (void)visible, (void)logging;
  if (!name || !guid || !callback || type != fmi2CoSimulation || strcmp(guid, "${guid}") != 0) return NULL;
  own = (Instance*)calloc(1, sizeof *own);
  if (!own) return NULL;
  own->name = (char*)malloc(strlen(name) + 1);
  if (!own->name) {
    free(own);
    return NULL;
  }
  strcpy(own->name, name);
  own->callback = *callback;
  restart(own);
  return own;
}

void FMI(fmi2FreeInstance)(fmi2Component c) {
  if (c) free(((Instance*)c)->name);
  free(c);
}

fmi2Status FMI(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
  (void)c, (void)on, (void)n, (void)categories;
  return fmi2OK;
}

fmi2Status FMI(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_given, fmi2Real tolerance,
                                    fmi2Real start, fmi2Boolean stop_given, fmi2Real stop) {
  (void)c, (void)tolerance_given, (void)tolerance, (void)start, (void)stop_given, (void)stop;
  return fmi2OK;
}

fmi2Status FMI(fmi2EnterInitializationMode)(fmi2Component c) { return c ? fmi2OK : fmi2Error; }

fmi2Status FMI(fmi2ExitInitializationMode)(fmi2Component c) {
  Instance* own = (Instance*)c;
  memcpy(own->boat.x, own->real + START, sizeof own->boat.x);
  show(own);
  return fmi2OK;
}

fmi2Status FMI(fmi2Terminate)(fmi2Component c) { return c ? fmi2OK : fmi2Error; }

fmi2Status FMI(fmi2Reset)(fmi2Component c) {
  restart((Instance*)c);
  return fmi2OK;
}

fmi2Status FMI(fmi2GetReal)(fmi2Component c, const fmi2ValueReference at[], size_t n, fmi2Real value[]) {
  const Instance* own = (const Instance*)c;
  size_t i;
  for (i = 0; i < n; ++i) {
    if (at[i] >= FORCE + FORCES) return complain(own, "no variable has this value reference");
    value[i] = own->real[at[i]];
  }
  return fmi2OK;
}

fmi2Status FMI(fmi2SetReal)(fmi2Component c, const fmi2ValueReference at[], size_t n, const fmi2Real value[]) {
  Instance* own = (Instance*)c;
  size_t i;
  for (i = 0; i < n; ++i) {
    if (at[i] >= STATE) return complain(own, "only inputs and start values may be set");
    own->real[at[i]] = value[i];
  }
  return fmi2OK;
}

/* Advance by h [s]; changed inputs are a new command, which is held. */
fmi2Status FMI(fmi2DoStep)(fmi2Component c, fmi2Real now, fmi2Real h, fmi2Boolean no_way_back) {
  Instance* own = (Instance*)c;
  (void)now, (void)no_way_back;
${scale_inputs}  if (memcmp(own->given, own->real, sizeof own->given) != 0) {
    if (!${name}_command(&own->boat, own->real)) return complain(own, "a command is not finite, or the queue of delayed commands is full");
    memcpy(own->given, own->real, sizeof own->given);
  }
  if (!${name}_step(&own->boat, h)) return complain(own, "the state diverged, or the step size is not a finite time >= 0");
  show(own);
  return fmi2OK;
}

fmi2Status FMI(fmi2CancelStep)(fmi2Component c) { return complain((Instance*)c, "no step is under way"); }

/* Snapshots: the instance as it is. */
fmi2Status FMI(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate* state) {
  if (!*state) *state = malloc(sizeof(Instance));
  if (!*state) return complain((Instance*)c, "no memory");
  memcpy(*state, c, sizeof(Instance));
  return fmi2OK;
}

fmi2Status FMI(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state) {
  Instance* own = (Instance*)c;
  char* name = own->name;
  memcpy(c, state, sizeof(Instance));
  own->name = name;
  return fmi2OK;
}

fmi2Status FMI(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate* state) {
  (void)c;
  free(*state);
  *state = NULL;
  return fmi2OK;
}

/* Functions that the model description excludes. */
#define NONE(n) return (n) == 0 ? fmi2OK : complain((Instance*)c, "there are real variables only")
#define REFUSED return complain((Instance*)c, "the model description says that this can't be done")
typedef const fmi2ValueReference* At;
fmi2Status FMI(fmi2GetInteger)(fmi2Component c, At at, size_t n, fmi2Integer* v) { (void)at, (void)v; NONE(n); }
fmi2Status FMI(fmi2GetBoolean)(fmi2Component c, At at, size_t n, fmi2Boolean* v) { (void)at, (void)v; NONE(n); }
fmi2Status FMI(fmi2GetString)(fmi2Component c, At at, size_t n, fmi2String* v) { (void)at, (void)v; NONE(n); }
fmi2Status FMI(fmi2SetInteger)(fmi2Component c, At at, size_t n, const fmi2Integer* v) { (void)at, (void)v; NONE(n); }
fmi2Status FMI(fmi2SetBoolean)(fmi2Component c, At at, size_t n, const fmi2Boolean* v) { (void)at, (void)v; NONE(n); }
fmi2Status FMI(fmi2SetString)(fmi2Component c, At at, size_t n, const fmi2String* v) { (void)at, (void)v; NONE(n); }
fmi2Status FMI(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate s, size_t* n) { (void)s, (void)n; REFUSED; }
fmi2Status FMI(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate s, fmi2Byte* b, size_t n) {
  (void)s, (void)b, (void)n;
  REFUSED;
}
fmi2Status FMI(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte* b, size_t n, fmi2FMUstate* s) {
  (void)b, (void)n, (void)s;
  REFUSED;
}
fmi2Status FMI(fmi2GetDirectionalDerivative)(fmi2Component c, At unknown, size_t nu, At known, size_t nk,
                                             const fmi2Real* d_known, fmi2Real* d_unknown) {
  (void)unknown, (void)nu, (void)known, (void)nk, (void)d_known, (void)d_unknown;
  REFUSED;
}
fmi2Status FMI(fmi2SetRealInputDerivatives)(fmi2Component c, At at, size_t n, const fmi2Integer* order, const fmi2Real* v) {
  (void)at, (void)n, (void)order, (void)v;
  REFUSED;
}
fmi2Status FMI(fmi2GetRealOutputDerivatives)(fmi2Component c, At at, size_t n, const fmi2Integer* order, fmi2Real* v) {
  (void)at, (void)n, (void)order, (void)v;
  REFUSED;
}
fmi2Status FMI(fmi2GetStatus)(fmi2Component c, fmi2StatusKind k, fmi2Status* v) { (void)k, (void)v; REFUSED; }
fmi2Status FMI(fmi2GetRealStatus)(fmi2Component c, fmi2StatusKind k, fmi2Real* v) { (void)k, (void)v; REFUSED; }
fmi2Status FMI(fmi2GetIntegerStatus)(fmi2Component c, fmi2StatusKind k, fmi2Integer* v) { (void)k, (void)v; REFUSED; }
fmi2Status FMI(fmi2GetBooleanStatus)(fmi2Component c, fmi2StatusKind k, fmi2Boolean* v) { (void)k, (void)v; REFUSED; }
fmi2Status FMI(fmi2GetStringStatus)(fmi2Component c, fmi2StatusKind k, fmi2String* v) { (void)k, (void)v; REFUSED; }
