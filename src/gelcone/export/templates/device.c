/* What DEVICE.h declares. */

void DEVICE_init(DEVICE *device) { begin(device); }

int DEVICE_set(DEVICE *device, int variable, double value) {
  return set_value(device, variable, value) ? DEVICE_UP_OK : DEVICE_UP_REFUSED;
}

double DEVICE_get(DEVICE *device, int variable) { return value_of(device, variable); }

int DEVICE_step(DEVICE *device, double seconds) {
  if (!(seconds >= 0.0 && seconds <= LARGEST)) return DEVICE_UP_REFUSED;
  return move_on(device, seconds);
}

const char *DEVICE_words(int outcome) { return words_of(outcome); }
