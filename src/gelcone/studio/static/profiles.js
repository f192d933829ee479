// Profiles of membranes over height and voltage, from small tables that the server sends once per film.
const MOST = 32;
const tables = new Map();

// Adds a table: arrays height and top; radius, rise, stretch, wrinkled (heights, shares, rings), flattened; name, shares.
export function add(words, arrays) {
  if (tables.size >= MOST) tables.delete(tables.keys().next().value);
  tables.set(words.name, { ...arrays, shares: words.shares, rings: words.rings });
}

// The rings from disc to rim at a height of the disc above the film's plane: radius, rise (height over the disc's),
// stretch (area over the mounted one) and whether the hoop is wrinkled. Null without a table, and where the voltage
// leaves the film without tension.
export function profile(name, height, voltage) {
  const table = tables.get(name);
  if (!table || !Number.isFinite(height)) return null;
  const [i, f] = place(table.height, Math.abs(height)), next = Math.min(i + 1, table.height.length - 1);
  const top = table.top[i] + (table.top[next] - table.top[i]) * f, share = voltage ** 2 / (top * top || 1e-30);
  if (voltage && share > 1) return null;
  const [j, e] = place(table.shares, voltage ? share : 0), later = Math.min(j + 1, table.shares.length - 1);
  const corners = [[i, j, (1 - f) * (1 - e)], [next, j, f * (1 - e)], [i, later, (1 - f) * e], [next, later, f * e]];
  return Array.from({ length: table.rings }, (_, k) => {
    const of = (values) => corners.reduce((sum, [row, column, weight]) => sum + weight * values[(row * table.shares.length + column) * table.rings + k], 0);
    return { radius: of(table.radius), rise: of(table.rise), stretch: of(table.stretch), wrinkled: of(table.wrinkled) > 0.5 };
  });
}

// The index before a value among rising ones, and the fraction of the way to the next.
function place(values, value) {
  let k = 0;
  while (k < values.length - 2 && values[k + 1] <= value) k++;
  return [k, Math.min(Math.max((value - values[k]) / (values[k + 1] - values[k]), 0), 1)];
}
