/* DEVICE_TITLE, exported by gelcone GELCONE_VERSION: the WebAssembly of DEVICE.wasm by names, in SI units. */

/** Numbers of the variables. Inputs, states and parameters may be set. */
export const VARIABLES = VARIABLES_TABLE;

/** A number of a variable; throws for a name that there is not. */
function place(name) {
  if (!Object.hasOwn(VARIABLES, name)) throw new Error(`${name} is not a variable of this device`);
  return VARIABLES[name];
}

/** A device at its start, from the bytes of DEVICE.wasm. */
export async function device(bytes) {
  const { instance } = await WebAssembly.instantiate(bytes);
  const { init, set, get, step } = instance.exports;
  init();
  return {
    /** Back to the start. */
    init,
    /** Sets an input, a state or a parameter; throws where the value is refused. */
    set(name, value) {
      if (set(place(name), value) !== 0) throw new Error(`${name} = ${value}: is refused`);
    },
    /** The value of a variable. */
    get: (name) => get(place(name)),
    /** Moves on by seconds; 0, or how the motion ended. */
    step,
  };
}
