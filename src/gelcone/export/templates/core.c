/* An instance of the device: a motion, its inputs and parameters in SI units, and what they give. */

enum { VOLTAGE, VOLTAGE_RATE, FORCE, FORCE_RATE, N_INPUTS };
enum { FILM_STATE, OUTCOME = N_FILMS, FILM_IS_SLACK, BREAKDOWN, NEAR_LIMIT, VALID, N_CODES };
enum { OK = 0, STRETCH_LIMIT = 2, STEP_LIMIT = 3, NOT_FINITE = 4, PULLED_IN = 6 };
enum { ARRIVED, INFINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, AT_BORDER };
enum {
  V_INPUT = 0,
  V_STATE = V_INPUT + N_INPUTS,
  V_RATE = V_STATE + N_STATES,
  V_OUTPUT = V_RATE + N_STATES,
  V_CODE = V_OUTPUT + N_OUTPUTS,
  V_TIME = V_CODE + N_CODES,
  V_PARAMETER = V_TIME + 1,
  N_VARIABLES = V_PARAMETER + N_PARAMETERS
};
#define ROOM(n) ((n) > 0 ? (n) : 1)
#define CROSSED (-1e-12)   /* a border counts as crossed below this */
#define TURN 6.283185307179586

static double scale(const instance *m, int which) { return m->numbers[N_NUMBERS + which].d; }

#ifdef N_PIECES
#define CLOSE (1e-11 * TURN) /* so near before a corner the next piece has begun */

/* The piece of the drive at the time now, the phase since it began, and in seconds what is left of it. */
static int piece_now(const instance *m, double *since, double *left) {
  double turns = m->s.parameter[P_FREQUENCY] * m->s.time, along, end;
  int k = N_PIECES - 1;
  if (REPEATS) turns -= floor(turns);
  along = TURN * turns - FIRST;
  if (REPEATS && along >= TURN - CLOSE) along -= TURN;
  if (REPEATS && along < -CLOSE) along += TURN;
  while (k > 0 && along < PIECE_OFFSETS[k] - CLOSE) --k;
  end = k + 1 < N_PIECES ? PIECE_OFFSETS[k + 1] : REPEATS ? TURN : INFINITY;
  *since = along - PIECE_OFFSETS[k];
  *left = (end - along) / (TURN * m->s.parameter[P_FREQUENCY]);
  return k;
}
#endif

/* Seconds after which the drive inside has a corner. */
static double until_corner(const instance *m) {
#ifdef N_PIECES
  double since, left;
  piece_now(m, &since, &left);
  return left;
#else
  (void)m;
  return INFINITY;
#endif
}

/* The numbers that the formulas take, from parameters and inputs. */
static void set_numbers(instance *m) {
  word given[ROOM(N_PARAMETERS)];
  double volt, force, time;
  int k;
  for (k = 0; k < N_PARAMETERS; ++k) given[k].d = m->s.parameter[k];
  set_closed_numbers(given, m->numbers);
  volt = scale(m, SCALE_VOLTAGE);
  force = scale(m, SCALE_FORCE);
  time = scale(m, SCALE_TIME);
  m->numbers[NUMBER_VOLTAGE].d = m->s.input[VOLTAGE] / volt;
  m->numbers[NUMBER_VOLTAGE_RATE].d = m->s.input[VOLTAGE_RATE] * time / volt;
  m->numbers[NUMBER_FORCE].d = m->s.input[FORCE] / force;
  m->numbers[NUMBER_FORCE_RATE].d = m->s.input[FORCE_RATE] * time / force;
#ifdef P_FREQUENCY
  {
    double turns = m->s.parameter[P_FREQUENCY] * m->s.time;
    m->numbers[NUMBER_PHASE].d = TURN * (turns - floor(turns));
  }
#endif
#ifdef N_PIECES
  {
    double left;
    const double *terms = PIECE_TERMS + 5 * piece_now(m, &m->numbers[NUMBER_DRIVE_SINCE].d, &left);
    m->numbers[NUMBER_DRIVE_0].d = terms[0];
    m->numbers[NUMBER_DRIVE_1].d = terms[1];
    m->numbers[NUMBER_DRIVE_2].d = terms[2];
    m->numbers[NUMBER_DRIVE_3].d = terms[3];
    m->numbers[NUMBER_DRIVE_GATE].d = terms[4];
  }
#endif
  m->fresh = 0;
}

static int law_of(const instance *m) {
  int k, law = 0;
  for (k = 0; k < N_TELLING; ++k) law |= (m->s.switches[TELLING[k]].d < 0) << k;
  return law;
}

/* Rates, outputs and borders where the motion is now. */
static const word *point(instance *m) {
  int k;
  if (m->fresh) return m->out;
  for (k = 0; k < ROOM(N_ROOTS); ++k) m->roots[k].d = NAN;
  POINTS[law_of(m)](m->s.z, 0.0, m->numbers, m->s.switches, m->roots, m->out);
  m->fresh = 1;
  return m->out;
}

/* Whether a film is stretched as far as it is known. */
static int beyond(const instance *m) {
  int k;
  for (k = 0; k < N_FILMS; ++k) {
    double x = m->s.z[0].d, own = FLAT_HEIGHT[k] < 0 ? x : m->numbers[FLAT_HEIGHT[k]].d - x;
    if (!(fabs(own) >= REACH[2 * k] && fabs(own) < REACH[2 * k + 1])) return 1;
  }
  return 0;
}

/* Flips the switches of borders that are crossed, and returns how many; ends where a film has pulled in. */
static int settle(instance *m) {
  int flipped = 0, again = 1, k;
  while (again && flipped < 16 && !m->s.outcome) {
    const word *out = point(m);
    again = 0;
    for (k = 0; k < N_BORDERS && !again; ++k) {
      if (!(out[OUT_BORDER + k].d < CROSSED)) continue;
      if (BORDER_SWITCH[k] < 0) m->s.outcome = PULLED_IN;
      else {
        m->s.switches[BORDER_SWITCH[k]].d = -m->s.switches[BORDER_SWITCH[k]].d;
        m->fresh = 0;
        ++flipped;
      }
      again = 1;
    }
  }
  if (!m->s.outcome && beyond(m)) m->s.outcome = STRETCH_LIMIT;
  return flipped;
}

/* One run of the compiled loop from the state now over a dimensionless time; how it ended, and when. */
static int64_t run(instance *m, double length, double *reached) {
  static const double never = INFINITY;
  word z[N_STATES], start, end, corner, smallest, most, result[N_STATES], status, steps, least, at, last[N_STATES];
  word dwell[ROOM(N_COMBINATIONS)], job[N_JOB];
  int k, going = 1;
  memcpy(z, m->s.z, sizeof z);
  start.d = 0.0;
  end.d = length;
  corner.d = never;
  smallest.d = SMALLEST_STEP;
  most.d = STEPS_PER_CALL * fmax(1.0, ceil(length * FASTEST / CALL_SPAN));
  status.i = -1;
  at.d = 0.0;
  memset(job, 0, sizeof job);
  memset(m->words, 0, sizeof m->words);
  for (k = 0; k < N_LAWS; ++k) m->words[CODE + k].f = (function)STEPS[k];
  m->words[SERVE].f = (function)serve;
  prepare(m->numbers, m->table, 1);
  job[JOB_TABLE].p = m->table;
  job[JOB_STATES].p = z;
  job[JOB_SWITCHES].p = m->s.switches;
  job[JOB_START].p = &start;
  job[JOB_TIMES].p = &end;
  job[JOB_CORNERS].p = &corner;
  job[JOB_SMALLEST].p = &smallest;
  job[JOB_MOST_STEPS].p = &most;
  job[JOB_RESULT].p = result;
  job[JOB_STATUS].p = &status;
  job[JOB_STEPS].p = &steps;
  job[JOB_LEAST].p = &least;
  job[JOB_END_TIME].p = &at;
  job[JOB_END_STATE].p = last;
  job[JOB_DWELL].p = dwell;
  job[JOB_MEMBERS].i = job[JOB_SAMPLES].i = job[JOB_CORNER_COUNT].i = job[JOB_PADDED].i = job[JOB_SLOTS].i = 1;
  start_run(m->lanes, job, m->words, m->store);
  while (going) {
    advance(m->lanes, m->scratch, job, m->words, m->store, 1 << 20);
    for (going = k = 0; k < N_LAWS; ++k) going |= m->words[k].i != 0;
  }
  memcpy(m->s.z, status.i == ARRIVED ? result : last, sizeof z);
  *reached = status.i == ARRIVED ? length : at.d;
  return status.i;
}

/* The outcome of a run that ended before its time. */
static int outcome_of(int64_t status) {
  if (status >= AT_BORDER) return PULLED_IN;
  if (status == TOO_MANY_STEPS) return STEP_LIMIT;
  return status == INFINITE && SMALLEST_STEP == 0.0 ? NOT_FINITE : STRETCH_LIMIT;
}

/* Moves on by a time in seconds, from corner to corner of the drive inside; the outcome. */
static int move_on(instance *m, double seconds) {
  double reached, now = m->s.time, done = 0.0;
  int64_t status = ARRIVED;
  if (m->s.outcome) return (int)m->s.outcome;
  set_numbers(m);
  if (seconds == 0.0) {
    settle(m);
    return (int)m->s.outcome;
  }
  while (done < seconds && !m->s.outcome) {
    double left = until_corner(m), part = left < seconds - done ? left : seconds - done;
    status = run(m, part / scale(m, SCALE_TIME), &reached);
    reached *= scale(m, SCALE_TIME);
    done = status != ARRIVED ? done + reached : part < left ? seconds : done + part;
    m->s.time = now + done;
    m->s.input[VOLTAGE] += m->s.input[VOLTAGE_RATE] * reached;
    m->s.input[FORCE] += m->s.input[FORCE_RATE] * reached;
    if (status != ARRIVED) m->s.outcome = outcome_of(status);
    else if (beyond(m)) m->s.outcome = STRETCH_LIMIT;
    set_numbers(m);
  }
  return (int)m->s.outcome;
}

static double code_of(instance *m, int which) {
  const word *out = point(m);
  int k, place = 0, slack = 0, pressed = 0, breakdown = 0, near = 0;
  for (k = 0; k < N_SWITCHES; ++k) place |= (m->s.switches[k].d < 0) << k;
  if (which < N_FILMS) return KIND[which * N_COMBINED + place];
  if (which == OUTCOME) return (double)m->s.outcome;
  for (k = 0; k < N_FILMS; ++k) {
    const int *own = FILM_OUT + 4 * k;
    double strength = m->s.parameter[P_DIELECTRIC_STRENGTH];
    if (HAS_KINDS[k]) slack |= SLACK[k * N_KINDS + KIND[k * N_COMBINED + place]];
    else if (own[0] >= 0) pressed |= out[own[0]].d < 0.0 || out[own[1]].d < 0.0;
    if (own[2] >= 0) breakdown |= strength > 0.0 && out[own[2]].d * scale(m, SCALE_FIELD) > strength;
    if (own[3] >= 0) near |= out[own[3]].d >= 0.99;
  }
  if (which == FILM_IS_SLACK) return slack || pressed;
  if (which == BREAKDOWN) return breakdown;
  if (which == NEAR_LIMIT) return near;
  return !(m->s.outcome || breakdown || near || pressed); /* a film that wrinkles is slack, and the model holds */
}

/* The value of a variable in SI units. */
static double value_of(instance *m, int variable) {
  if (variable < 0 || variable >= N_VARIABLES) return NAN;
  if (variable < V_STATE) return m->s.input[variable - V_INPUT];
  if (variable < V_RATE) return m->s.z[variable - V_STATE].d * scale(m, STATE_SCALE[variable - V_STATE]);
  if (variable < V_OUTPUT) {
    int k = variable - V_RATE;
    return point(m)[k].d * scale(m, STATE_SCALE[k]) / scale(m, SCALE_TIME);
  }
  if (variable < V_CODE) {
    int k = variable - V_OUTPUT;
    return point(m)[OUTPUT_PLACE[k]].d * scale(m, OUTPUT_SCALE[k]);
  }
  if (variable < V_TIME) return code_of(m, variable - V_CODE);
  if (variable == V_TIME) return m->s.time;
  return m->s.parameter[variable - V_PARAMETER];
}

/* Sets an input, a state or a parameter; 0 where the value or the variable is refused, and then nothing changes.
   States stay what they are in SI units where a parameter changes the scales. */
static int set_value(instance *m, int variable, double value) {
  double own[N_STATES];
  int k;
  if (!(fabs(value) <= LARGEST) || variable < 0 || variable >= N_VARIABLES) return 0;
  if (variable < V_STATE) {
    m->s.input[variable - V_INPUT] = value;
    set_numbers(m);
    return 1;
  }
  if (variable < V_RATE) {
    m->s.z[variable - V_STATE].d = value / scale(m, STATE_SCALE[variable - V_STATE]);
    m->fresh = 0;
    return 1;
  }
  if (variable < V_PARAMETER) return 0;
  k = variable - V_PARAMETER;
  if (value < LEAST[k] || (value == LEAST[k] && EXCLUSIVE[k])) return 0;
  m->s.parameter[k] = value;
  for (k = 0; k < N_STATES; ++k) own[k] = m->s.z[k].d * scale(m, STATE_SCALE[k]);
  set_numbers(m);
  for (k = 0; k < N_STATES; ++k) m->s.z[k].d = own[k] / scale(m, STATE_SCALE[k]);
  return 1;
}

/* The start of a motion: at the device's rest, without voltage or force from outside. */
static void begin(instance *m) {
  int k;
  memset(m, 0, sizeof *m);
  for (k = 0; k < N_NUMBERS; ++k) m->numbers[k].d = NUMBERS[k];
  for (k = 0; k < N_PARAMETERS; ++k) m->s.parameter[k] = PARAMETERS[k];
  for (k = 0; k < N_STATES; ++k) m->s.z[k].d = START[k];
  for (k = 0; k < N_SWITCHES; ++k) m->s.switches[k].d = START_SWITCHES[k];
  set_numbers(m);
}

static const char *words_of(int outcome) {
  switch (outcome) {
  case OK: return "ok";
  case STRETCH_LIMIT: return TEXT_STRETCH_LIMIT;
  case STEP_LIMIT: return TEXT_STEP_LIMIT;
  case NOT_FINITE: return TEXT_NOT_FINITE;
  case PULLED_IN: return TEXT_PULLED_IN;
  default: return "refused: not a finite number, out of bounds, or a variable that is not set";
  }
}
