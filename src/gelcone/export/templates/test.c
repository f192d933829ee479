/* Whether this compiler gives the bits of gelcone: states of the compiled integrator at the ends of some steps.

   cc -std=c99 -O2 -ffp-contract=off test.c DEVICE.c -lm -o test && ./test */
#include "DEVICE.h"

#include <stdio.h>
#include <string.h>

static const double STEP[][3] = { /* seconds, volts, volts per second */
STEPS_TABLE
};
static const uint64_t RIGHT[][TEST_STATES] = { /* the bits of the states behind each step */
RIGHT_TABLE
};

int main(void) {
  static DEVICE device;
  const int count = (int)(sizeof STEP / sizeof STEP[0]);
  int k, i, same = 0;
  DEVICE_init(&device);
  for (k = 0; k < count; ++k) {
    int equal = 1;
    DEVICE_set(&device, DEVICE_UP_VOLTAGE, STEP[k][1]);
    DEVICE_set(&device, DEVICE_UP_VOLTAGE_RATE, STEP[k][2]);
    DEVICE_step(&device, STEP[k][0]);
    for (i = 0; i < TEST_STATES; ++i) {
      uint64_t bits;
      memcpy(&bits, &device.s.z[i].d, sizeof bits);
      equal = equal && bits == RIGHT[k][i];
    }
    same += equal;
  }
  printf("%d of %d steps with the bits of gelcone\n", same, count);
  return same != count;
}
