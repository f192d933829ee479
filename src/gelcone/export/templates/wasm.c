/* The device as a WebAssembly module without imports: init, set, get and step; a module instance is one device. */
#include "DEVICE.c"

static DEVICE one_device;

__attribute__((export_name("init"))) void wasm_init(void) { begin(&one_device); }
__attribute__((export_name("set"))) int wasm_set(int variable, double value) { return DEVICE_set(&one_device, variable, value); }
__attribute__((export_name("get"))) double wasm_get(int variable) { return DEVICE_get(&one_device, variable); }
__attribute__((export_name("step"))) int wasm_step(double seconds) { return DEVICE_step(&one_device, seconds); }
