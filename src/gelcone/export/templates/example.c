/* The device under its drive, a value a millisecond: time, voltage, displacement and current.

   cc -std=c99 -O2 -ffp-contract=off example.c DEVICE.c -lm -o example && ./example > motion.csv */
#include "DEVICE.h"

#include <math.h>
#include <stdio.h>

int main(void) {
  static DEVICE device;
  const double step = 1e-3, turn = 6.283185307179586;
  int k, outcome = DEVICE_UP_OK;
  DEVICE_init(&device);
  puts("time (s),voltage (V),displacement (m),current (A)");
  for (k = 0; k < EXAMPLE_STEPS && outcome == DEVICE_UP_OK; ++k) {
    double before = DRIVE_AT(k * step), after = DRIVE_AT((k + 1) * step);
    DEVICE_set(&device, DEVICE_UP_VOLTAGE, before);
    DEVICE_set(&device, DEVICE_UP_VOLTAGE_RATE, (after - before) / step);
    outcome = DEVICE_step(&device, step);
    printf("%.6f,%.9g,%.9g,%.9g\n", DEVICE_get(&device, DEVICE_UP_TIME), DEVICE_get(&device, DEVICE_UP_VOLTAGE),
           DEVICE_get(&device, DEVICE_UP_DISPLACEMENT), DEVICE_get(&device, DEVICE_UP_CURRENT));
  }
  if (outcome != DEVICE_UP_OK) fprintf(stderr, "%s\n", DEVICE_words(outcome));
  return outcome != DEVICE_UP_OK;
}
