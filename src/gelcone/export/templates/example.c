/* The device under its drive, a value a millisecond: time, FIRST_SHOWN, displacement and current.

   cc -std=c99 -O2 -ffp-contract=off example.c DEVICE.c -lm -o example && ./example > motion.csv */
#include "DEVICE.h"

#include <math.h>
#include <stdio.h>

int main(void) {
  static DEVICE device;
  const double step = 1e-3, TURN_SET;
  int k, outcome = DEVICE_UP_OK;
  DEVICE_init(&device);
  puts("time (s),FIRST_SHOWN (V),displacement (m),LAST_SHOWN");
  for (k = 0; k < 1000 && outcome == DEVICE_UP_OK; ++k) {
DRIVE_SET
    outcome = DEVICE_step(&device, step);
    printf("%.6f,%.9g,%.9g,%.9g\n", DEVICE_get(&device, DEVICE_UP_TIME), DEVICE_get(&device, DEVICE_UP_FIRST_NAME),
           DEVICE_get(&device, DEVICE_UP_DISPLACEMENT), DEVICE_get(&device, DEVICE_UP_LAST_NAME));
  }
  if (outcome != DEVICE_UP_OK) fprintf(stderr, "%s\n", DEVICE_words(outcome));
  return outcome != DEVICE_UP_OK;
}
