/* FMI 3.0 for co-simulation and model exchange. The interface of the standard (fmi-standard.org) is declared here anew. */
#include "fmu.c"

#include <stdbool.h>

#if defined(FMI3_FUNCTION_PREFIX)
#define JOINED(a, b) a##b
#define JOIN(a, b) JOINED(a, b)
#define FMI(name) JOIN(FMI3_FUNCTION_PREFIX, name)
#else
#define FMI(name) name
#endif

typedef void *Instance;
typedef uint32_t Reference;
typedef const char *String;
typedef enum { IntervalNotYetKnown, IntervalUnchanged, IntervalChanged } IntervalQualifier;
typedef enum { Independent, Constant, Fixed, Tunable, Discrete, Dependent } DependencyKind;
typedef void (*Logger)(void *, Status, String, String);
typedef void (*Callback)(void);

#define DECLARED(type, name, arguments) EXPORTED type FMI(name) arguments; EXPORTED type FMI(name) arguments
#define UNUSED(a) (void)(a)

static Status reported(void *c, Status status, const char *text) {
  const component *own = (const component *)c;
  if (own->logger) ((Logger)own->logger)(own->environment, status, "logStatusError", text);
  return status;
}
static Instance made(String name, String token, void *environment, Logger logger, bool early) {
  component *c = new_component(name, token);
  if (c) {
    c->environment = environment;
    c->logger = (function)logger;
    c->early = early;
  }
  return c;
}

/* --- instances ---------------------------------------------------------------------------------------------------- */

DECLARED(String, fmi3GetVersion, (void)) { return "3.0"; }
DECLARED(Status, fmi3SetDebugLogging, (Instance i, bool on, size_t n, const String names[])) {
  UNUSED(i); UNUSED(on); UNUSED(n); UNUSED(names);
  return FmiOK;
}
DECLARED(Instance, fmi3InstantiateModelExchange, (String name, String token, String place, bool visible, bool logging,
                                                  void *environment, Logger logger)) {
  UNUSED(place); UNUSED(visible); UNUSED(logging);
  return made(name, token, environment, logger, false);
}
DECLARED(Instance, fmi3InstantiateCoSimulation, (String name, String token, String place, bool visible, bool logging,
                                                 bool events, bool early, const Reference needed[], size_t n,
                                                 void *environment, Logger logger, Callback update)) {
  UNUSED(place); UNUSED(visible); UNUSED(logging); UNUSED(events); UNUSED(needed); UNUSED(n); UNUSED(update);
  return made(name, token, environment, logger, early);
}
DECLARED(Instance, fmi3InstantiateScheduledExecution, (String name, String token, String place, bool visible, bool logging,
                                                       void *environment, Logger logger, Callback clocks, Callback lock,
                                                       Callback unlock)) {
  UNUSED(name); UNUSED(token); UNUSED(place); UNUSED(visible); UNUSED(logging); UNUSED(environment); UNUSED(logger);
  UNUSED(clocks); UNUSED(lock); UNUSED(unlock);
  return NULL;
}
DECLARED(void, fmi3FreeInstance, (Instance i)) { free_component((component *)i); }
DECLARED(Status, fmi3EnterInitializationMode, (Instance i, bool known, double tolerance, double start, bool ends,
                                               double stop)) {
  UNUSED(known); UNUSED(tolerance); UNUSED(ends); UNUSED(stop);
  return set_time(i, start);
}
DECLARED(Status, fmi3ExitInitializationMode, (Instance i)) { return initialized(i); }
DECLARED(Status, fmi3Reset, (Instance i)) { begin(of(i)); return FmiOK; }
#define NOTHING(name) DECLARED(Status, name, (Instance i)) { UNUSED(i); return FmiOK; }
NOTHING(fmi3EnterEventMode)
NOTHING(fmi3Terminate)
NOTHING(fmi3EnterConfigurationMode)
NOTHING(fmi3ExitConfigurationMode)
NOTHING(fmi3EvaluateDiscreteStates)
NOTHING(fmi3EnterContinuousTimeMode)
NOTHING(fmi3EnterStepMode)

/* --- values ------------------------------------------------------------------------------------------------------- */

#define NO_GET(T, type) \
  DECLARED(Status, fmi3Get##T, (Instance i, const Reference vr[], size_t n, type value[], size_t m)) { \
    UNUSED(i); UNUSED(vr); UNUSED(value); UNUSED(m); return n ? FmiError : FmiOK; }
#define NO_SET(T, type) \
  DECLARED(Status, fmi3Set##T, (Instance i, const Reference vr[], size_t n, const type value[], size_t m)) { \
    UNUSED(i); UNUSED(vr); UNUSED(value); UNUSED(m); return n ? FmiError : FmiOK; }
#define NEITHER(T, type) NO_GET(T, type) NO_SET(T, type)
NEITHER(Float32, float)
NEITHER(Int8, int8_t)
NEITHER(UInt8, uint8_t)
NEITHER(Int16, int16_t)
NEITHER(UInt16, uint16_t)
NEITHER(UInt32, uint32_t)
NEITHER(Int64, int64_t)
NEITHER(UInt64, uint64_t)
NEITHER(String, String)
NO_SET(Int32, int32_t)
NO_SET(Boolean, bool)

/* Event indicators are variables behind all others. */
DECLARED(Status, fmi3GetFloat64, (Instance i, const Reference vr[], size_t n, double value[], size_t m)) {
  size_t k;
  UNUSED(m);
  for (k = 0; k < n; ++k) {
    if (vr[k] >= N_VARIABLES && vr[k] < N_VARIABLES + N_BORDERS)
      value[k] = point(of(i))[OUT_BORDER + vr[k] - N_VARIABLES].d + SHIFT;
    else if (get_reals(i, vr + k, 1, value + k)) return FmiError;
  }
  return FmiOK;
}
DECLARED(Status, fmi3SetFloat64, (Instance i, const Reference vr[], size_t n, const double value[], size_t m)) {
  UNUSED(m);
  return set_reals(i, vr, n, value);
}
DECLARED(Status, fmi3GetInt32, (Instance i, const Reference vr[], size_t n, int32_t value[], size_t m)) {
  size_t k;
  UNUSED(m);
  for (k = 0; k < n; ++k) {
    if (!is_whole(vr[k])) return FmiError;
    value[k] = (int32_t)value_of(of(i), (int)vr[k]);
  }
  return FmiOK;
}
DECLARED(Status, fmi3GetBoolean, (Instance i, const Reference vr[], size_t n, bool value[], size_t m)) {
  size_t k;
  UNUSED(m);
  for (k = 0; k < n; ++k) {
    if (!is_truth(vr[k])) return FmiError;
    value[k] = value_of(of(i), (int)vr[k]) != 0.0;
  }
  return FmiOK;
}
DECLARED(Status, fmi3GetBinary, (Instance i, const Reference vr[], size_t n, size_t sizes[], const uint8_t *value[],
                                 size_t m)) {
  UNUSED(i); UNUSED(vr); UNUSED(sizes); UNUSED(value); UNUSED(m);
  return n ? FmiError : FmiOK;
}
DECLARED(Status, fmi3SetBinary, (Instance i, const Reference vr[], size_t n, const size_t sizes[],
                                 const uint8_t *const value[], size_t m)) {
  UNUSED(i); UNUSED(vr); UNUSED(sizes); UNUSED(value); UNUSED(m);
  return n ? FmiError : FmiOK;
}
DECLARED(Status, fmi3GetClock, (Instance i, const Reference vr[], size_t n, bool value[])) {
  UNUSED(i); UNUSED(vr); UNUSED(value);
  return n ? FmiError : FmiOK;
}
DECLARED(Status, fmi3SetClock, (Instance i, const Reference vr[], size_t n, const bool value[])) {
  UNUSED(i); UNUSED(vr); UNUSED(value);
  return n ? FmiError : FmiOK;
}
DECLARED(Status, fmi3GetNumberOfVariableDependencies, (Instance i, Reference vr, size_t *n)) {
  UNUSED(i); UNUSED(vr); UNUSED(n);
  return FmiError;
}
DECLARED(Status, fmi3GetVariableDependencies, (Instance i, Reference vr, size_t a[], Reference b[], size_t d[],
                                               DependencyKind k[], size_t n)) {
  UNUSED(i); UNUSED(vr); UNUSED(a); UNUSED(b); UNUSED(d); UNUSED(k); UNUSED(n);
  return FmiError;
}
DECLARED(Status, fmi3GetFMUState, (Instance i, void **stored)) { return store(&of(i)->s, stored); }
DECLARED(Status, fmi3SetFMUState, (Instance i, void *stored)) { return restore(i, stored); }
DECLARED(Status, fmi3FreeFMUState, (Instance i, void **stored)) { UNUSED(i); return discard(stored); }
DECLARED(Status, fmi3SerializedFMUStateSize, (Instance i, void *stored, size_t *n)) {
  UNUSED(i); UNUSED(stored);
  *n = sizeof(state);
  return FmiOK;
}
DECLARED(Status, fmi3SerializeFMUState, (Instance i, void *stored, uint8_t bytes[], size_t n)) {
  UNUSED(i);
  return to_bytes(stored, bytes, n);
}
DECLARED(Status, fmi3DeserializeFMUState, (Instance i, const uint8_t bytes[], size_t n, void **stored)) {
  return of_bytes(i, bytes, n, stored);
}
#define NO_DERIVATIVE(name) \
  DECLARED(Status, name, (Instance i, const Reference u[], size_t nu, const Reference k[], size_t nk, const double s[], \
                          size_t ns, double v[], size_t nv)) { \
    UNUSED(i); UNUSED(u); UNUSED(nu); UNUSED(k); UNUSED(nk); UNUSED(s); UNUSED(ns); UNUSED(v); UNUSED(nv); \
    return FmiError; }
NO_DERIVATIVE(fmi3GetDirectionalDerivative)
NO_DERIVATIVE(fmi3GetAdjointDerivative)
DECLARED(Status, fmi3GetIntervalDecimal, (Instance i, const Reference vr[], size_t n, double v[], IntervalQualifier q[])) {
  UNUSED(i); UNUSED(vr); UNUSED(n); UNUSED(v); UNUSED(q);
  return FmiError;
}
DECLARED(Status, fmi3GetIntervalFraction, (Instance i, const Reference vr[], size_t n, uint64_t a[], uint64_t b[],
                                           IntervalQualifier q[])) {
  UNUSED(i); UNUSED(vr); UNUSED(n); UNUSED(a); UNUSED(b); UNUSED(q);
  return FmiError;
}
#define NO_DECIMAL(name, type) \
  DECLARED(Status, name, (Instance i, const Reference vr[], size_t n, type v[])) { \
    UNUSED(i); UNUSED(vr); UNUSED(n); UNUSED(v); return FmiError; }
#define NO_FRACTION(name, type) \
  DECLARED(Status, name, (Instance i, const Reference vr[], size_t n, type a[], type b[])) { \
    UNUSED(i); UNUSED(vr); UNUSED(n); UNUSED(a); UNUSED(b); return FmiError; }
NO_DECIMAL(fmi3GetShiftDecimal, double)
NO_FRACTION(fmi3GetShiftFraction, uint64_t)
NO_DECIMAL(fmi3SetIntervalDecimal, const double)
NO_FRACTION(fmi3SetIntervalFraction, const uint64_t)
NO_DECIMAL(fmi3SetShiftDecimal, const double)
NO_FRACTION(fmi3SetShiftFraction, const uint64_t)

/* --- model exchange ----------------------------------------------------------------------------------------------- */

DECLARED(Status, fmi3UpdateDiscreteStates, (Instance i, bool *again, bool *terminate, bool *nominals, bool *values,
                                            bool *next, double *when)) {
  *again = *nominals = *values = false;
  *next = until_corner(of(i)) < INFINITY;
  *when = *next ? of(i)->s.time + until_corner(of(i)) : 0.0;
  settle(of(i));
  *terminate = of(i)->s.outcome != OK;
  return FmiOK;
}
DECLARED(Status, fmi3CompletedIntegratorStep, (Instance i, bool no_set, bool *enter, bool *terminate)) {
  UNUSED(no_set);
  *enter = false;
  *terminate = ended(i);
  return FmiOK;
}
DECLARED(Status, fmi3SetTime, (Instance i, double time)) { return set_time(i, time); }
DECLARED(Status, fmi3SetContinuousStates, (Instance i, const double x[], size_t n)) { return set_states(i, x, n); }
DECLARED(Status, fmi3GetContinuousStateDerivatives, (Instance i, double rate[], size_t n)) { return get_rates(i, rate, n); }
DECLARED(Status, fmi3GetEventIndicators, (Instance i, double value[], size_t n)) { return get_indicators(i, value, n); }
DECLARED(Status, fmi3GetContinuousStates, (Instance i, double x[], size_t n)) { return get_states(i, x, n); }
DECLARED(Status, fmi3GetNominalsOfContinuousStates, (Instance i, double x[], size_t n)) { return get_nominals(i, x, n); }
DECLARED(Status, fmi3GetNumberOfEventIndicators, (Instance i, size_t *n)) { UNUSED(i); *n = N_BORDERS; return FmiOK; }
DECLARED(Status, fmi3GetNumberOfContinuousStates, (Instance i, size_t *n)) { UNUSED(i); *n = N_STATES; return FmiOK; }

/* --- co-simulation ------------------------------------------------------------------------------------------------ */

DECLARED(Status, fmi3GetOutputDerivatives, (Instance i, const Reference vr[], size_t n, const int32_t order[],
                                            double value[], size_t m)) {
  UNUSED(i); UNUSED(vr); UNUSED(n); UNUSED(order); UNUSED(value); UNUSED(m);
  return FmiError;
}
DECLARED(Status, fmi3DoStep, (Instance i, double now, double size, bool no_set, bool *event, bool *terminate, bool *early,
                              double *last)) {
  int outcome = stepped(i, now, size);
  UNUSED(no_set);
  *event = *early = *terminate = false;
  *last = outcome < 0 ? now : of(i)->s.time;
  if (outcome < 0) return refused(i);
  if (!outcome) return FmiOK;
  *terminate = true;
  *early = ((component *)i)->early && *last < now + size;
  return reported(i, FmiWarning, words_of(outcome));
}
DECLARED(Status, fmi3ActivateModelPartition, (Instance i, Reference vr, double time)) {
  UNUSED(i); UNUSED(vr); UNUSED(time);
  return FmiError;
}
