// The cone: film, disc, gauge and what acts on the disc, each at its place.
import assert from "node:assert/strict";
import test from "node:test";
import { LIGHT, boxes, browser, drawn, forget, near, page, texts } from "./page.js";

browser();
const from = (name) => import(`../../../src/gelcone/studio/static/${name}.js`);
const { Cone } = await from("cone");
const AXES = { time: "time (ms)", displacement: "height (mm)", velocity: "velocity (m/s)", voltage: "voltage (V)", constant: "constant voltage (V)", frequency: "frequency (Hz)", amplitude: "amplitude (mm)" };
const ABOUT = { axes: AXES, si: true, film_of: "cone", disc: 8, rim: 30, second: null, bias: "spring", film: [], wrinkles: false };
const FILM = [LIGHT.taut, LIGHT.around, LIGHT.meridian, LIGHT.both, LIGHT.breakdown, LIGHT.limit, LIGHT.beyond];
const close = (one, other) => one.length === other.length && one.every((pair, k) => near(pair[0], other[k][0], 1e-4) && near(pair[1], other[k][1], 1e-4));

function cone(sides) {
  const canvas = document.createElement("canvas"), own = new Cone(canvas);
  own.draw(sides.map((side) => ({ about: ABOUT, height: 10, films: [0, 0], low: 0, high: 20, volts: [-1000, 2000], voltage: 500, heightText: "10 mm", voltageText: "500 V", ...side })));
  return { own, g: canvas.getContext() };
}

// The quadrilaterals of a film in perspective: their corners, as they are filled one after the other; and when the disc is.
function faces(side) {
  const { own, g } = cone([side, {}]), calls = g.calls.slice(0, g.calls.findIndex((c) => c.name === "restore")), found = []; // the first of two
  let corners = [], disc = -1;
  for (const c of calls) {
    if (c.name === "moveTo" || (c.name === "lineTo" && corners.length)) corners.push(c.args);
    if (c.name === "closePath" && corners.length === 4) found.push(corners);
    if (["closePath", "beginPath"].includes(c.name)) corners = [];
    if (c.name === "fill" && c.fillStyle === LIGHT.steel) disc = found.length;
  }
  const whole = { about: ABOUT, low: 0, high: 20 }, scale = own.scale(whole);
  return { found, disc, scale, ground: own.ground(whole, 480, scale) };
}

test("the cone in section: film from rim to disc at its height and in the colour of its state", () => {
  for (const [height, film] of [[10, 0], [20, 1], [0, 4], [5, 5]]) {
    const { own, g } = cone([{ height, films: [film, 0] }]), side = { about: ABOUT, low: 0, high: 20 };
    const scale = own.scale(side), ground = own.ground(side, 480, scale), middle = (640 - 46) / 4;
    const lines = g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === FILM[film] && c.lineWidth > 2).map((c) => c.args);
    const ends = [[-1, 30, 0], [-1, 8, height], [1, 30, 0], [1, 8, height]].map(([sign, r, z]) => [middle + sign * r * scale, ground - z * scale]);
    for (const end of ends) assert.ok(lines.some((at) => close([at], [end])), `${height}`);
    assert.ok(texts(g).includes("10 mm") && texts(g).includes("500 V") && texts(g).includes("voltage"));
  }
});

test("a cone that is given another size asks to be drawn in it, and is", () => {
  const { own } = cone([{}]), resized = page.observers.at(-1);
  let woken = 0;
  own.wakes = () => { woken += 1; };
  for (const [w, h] of [[900, 300], [300, 700]]) {
    Object.assign(own.canvas, { clientWidth: w, clientHeight: h });
    own.changed = false; resized();
    assert.deepEqual([own.canvas.width, own.canvas.height, own.changed], [w, h, true]);
    forget(own.context);
    own.draw([{ about: ABOUT, height: 10, films: [0, 0], low: 0, high: 20, volts: [0, 100], voltage: 50, heightText: "10 mm", voltageText: "50 V" }]);
    const rims = own.context.calls.filter((c) => c.name === "ellipse").map((c) => c.args[2]);
    assert.ok(Math.max(...rims) < w / 4 && Math.max(...rims) > 30);
  }
  assert.equal(woken, 2);
});

test("a cone is as large as its canvas allows, whichever side is the narrow one", () => {
  for (const [low, high, rim] of [[0, 20, 30], [0, 400, 30], [-300, 100, 30], [0, 5, 300], [0, 0, 30]]) {
    const about = { ...ABOUT, rim, disc: rim / 4 }, side = { about, low, high };
    for (const [height, other] of [[high, 0], [low, 0], [high, high || null]]) {
      const { own, g } = cone([{ about: { ...about, second: other || null }, low, high, height }]);
      const shown = g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === FILM[0] && c.lineWidth > 2).map((c) => [c.args[0] + c.shift[0], c.args[1] + c.shift[1]]);
      assert.ok(shown.length > 0 && shown.every(([x, y]) => x >= 0 && x <= 640 && y >= 0 && y <= 480), `${low} ${high} ${rim}`);
    }
    const { own } = cone([side]), [most, least] = own.reach(side), scale = own.scale(side);
    assert.ok(near(Math.max((2.28 * rim * scale) / (0.5 * (640 - 46)), ((most - least + 0.75 * rim) * scale) / (480 - 54)), 1, 1e-9));
  }
});

test("a membrane is drawn along its own profile, wrinkled rings dashed and in their colour; a slack one as it was", () => {
  const shape = [{ radius: 8, rise: 1, stretch: 2, wrinkled: false }, { radius: 15, rise: 0.3, stretch: 1.5, wrinkled: true }, { radius: 30, rise: 0, stretch: 1, wrinkled: true }];
  const { own, g } = cone([{ films: [1, 0], shapes: [shape, null], thin: [0.5, NaN], field: [0, 0] }]), side = { about: ABOUT, low: 0, high: 20 };
  const scale = own.scale(side), ground = own.ground(side, 480, scale), middle = (640 - 46) / 4;
  const place = (sign, k) => [middle + sign * shape[k].radius * scale, ground - 10 * shape[k].rise * scale];
  const [taut, wrinkled] = [0, 1].map((film) => g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === FILM[film] && c.lineWidth > 1).slice(0, 4));
  assert.ok(close(taut.map((c) => c.args), [place(-1, 0), place(-1, 1), place(1, 0), place(1, 1)]));
  assert.ok(close(wrinkled.map((c) => c.args), [place(-1, 1), place(-1, 2), place(1, 1), place(1, 2)]));
  assert.ok(taut.every((c) => !c.dash.length) && wrinkled.every((c) => c.dash.length));
  assert.ok(near(taut[0].lineWidth, 5 * 0.5 * (2 / 1.75)) && near(wrinkled[0].lineWidth, 5 * 0.5 * (2 / 1.25)));
  const slack = cone([{ films: [2, 0], shapes: [shape, null] }]).g.calls.filter((c) => c.name === "lineTo" && c.strokeStyle === FILM[2] && c.lineWidth > 2);
  assert.equal(slack.length, 2 * 49);
});

test("slack films wave and are pleated: around, from rim to disc, or both", () => {
  const { own } = cone([{}]);
  const shade = (film, sector, ring) => own.shade(film, 1, 0.3, sector, ring, true);
  const light = (...facet) => shade(...facet).match(/\d+/g).reduce((sum, v) => sum + Number(v), 0);
  assert.equal(shade(0, 1, 0), shade(0, 2, 0));
  assert.ok(light(1, 1, 0) < light(1, 2, 0)); // the inside of a pleat is darker
  assert.equal(shade(1, 1, 0), shade(1, 1, 1));
  assert.ok(light(2, 1, 1) < light(2, 1, 0));
  assert.equal(shade(2, 1, 0), shade(2, 2, 0));
  assert.ok(light(3, 1, 0) < light(3, 2, 0) && light(3, 1, 1) < light(3, 1, 0));
  const straight = (film) => {
    const { g } = cone([{ films: [film, 0] }]), points = g.calls.filter((c) => c.name === "lineTo" && c.strokeStyle === FILM[film] && c.lineWidth > 2).map((c) => c.args).slice(0, 49);
    const [x0, y0] = points[0], [x1, y1] = points[48];
    return Math.max(...points.map(([x, y]) => Math.abs((x - x0) * (y1 - y0) - (y - y0) * (x1 - x0)) / Math.hypot(x1 - x0, y1 - y0))) < 0.01;
  };
  assert.deepEqual([0, 1, 2, 3, 4].map(straight), [true, true, false, false, true]);
  for (const film of [2, 3]) { // each wave goes as far to either side, across the film
    const { g } = cone([{ films: [film, 0] }]), points = g.calls.filter((c) => c.name === "lineTo" && c.strokeStyle === FILM[film] && c.lineWidth > 2).map((c) => c.args).slice(0, 49), [[x0, y0]] = points, [x1, y1] = points[48];
    const along = points.map(([x, y]) => ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / ((x1 - x0) ** 2 + (y1 - y0) ** 2)), across = points.map(([x, y]) => ((x - x0) * (y1 - y0) - (y - y0) * (x1 - x0)) / Math.hypot(x1 - x0, y1 - y0));
    assert.ok(along.every((share, i) => near(share, i / 48, 1e-9)) && across.every((v, i) => near(v, -across[48 - i], 1e-9)));
  }
});

test("the gauge is filled from zero to the voltage", () => {
  const bar = (voltage, volts) => cone([{ voltage, volts }]).g.calls.filter((c) => c.name === "roundRect" && c.fillStyle === LIGHT.accent)[0].args;
  const Y = (v) => 480 - 24 - ((v + 1000) / 3000) * (480 - 24 - 22);
  assert.ok(near(bar(500, [-1000, 2000])[1], Y(500)) && near(bar(500, [-1000, 2000])[3], Y(0) - Y(500)));
  assert.ok(near(bar(-500, [-1000, 2000])[1], Y(0)) && near(bar(-500, [-1000, 2000])[3], Y(-500) - Y(0)));
  const above = bar(1000, [500, 2000]); // of voltages that are all above zero from the least of them
  assert.ok(near(above[1] + above[3], 480 - 24) && near(above[3], (480 - 24 - 22) / 3));
});

test("all that moves stays in the picture, whatever the sizes", () => {
  for (const side of [{ low: 0, high: 80 }, { low: -60, high: 5 }, { low: 0, high: 1 }]) {
    const { own } = cone([side]), whole = { about: ABOUT, ...side }, scale = own.scale(whole), ground = own.ground(whole, 480, scale);
    for (const z of [side.low, side.high]) assert.ok(ground - z * scale > 0 && ground - z * scale < 480, `${z}`);
    assert.ok(2 * 30 * scale < 320);
  }
});

test("in perspective the far half of a film is drawn first, the near half last, and the disc over what it covers", () => {
  for (const height of [10, -10]) {
    const { found, disc } = faces({ height, low: -20 }), half = found.length / 2, up = (part) => part.flat().reduce((sum, [, y]) => sum + y, 0) / part.length;
    assert.ok(half > 10 && up(found.slice(0, half)) < up(found.slice(half)), `${height}`);
    assert.equal(disc, height < 0 ? half : found.length);
  }
});

test("in perspective the rings of a membrane are at their radii and heights", () => {
  const shape = [8, 11, 14, 20, 30].map((radius, k) => ({ radius, rise: [1, 0.7, 0.4, 0.1, 0][k], stretch: 1 + 0.1 * k, wrinkled: false }));
  const { found, scale, ground } = faces({ height: 10, shapes: [shape, null], thin: [1, NaN], field: [0, 0] });
  const near = found.slice(found.length / 2, found.length / 2 + 2), middle = near[0][0][0] - 30 * scale, drawn = near.map(([[x, y]]) => [x, y]);
  const up = (ground - drawn[1][1]) / (10 * 0.4 * scale); // how much of a height is seen
  assert.ok(up > 0.5 && up < 1);
  assert.ok(close(drawn, [[middle + 30 * scale, ground], [middle + 14 * scale, ground - 4 * scale * up]]));
  assert.ok(close([near[1][3]], [[middle + 8 * scale, ground - 10 * scale * up]]));
});

test("the plane of a second film stays in the picture, wherever it is", () => {
  for (const second of [80, 15, -15, -80]) {
    const { own } = cone([{ about: { ...ABOUT, second } }]), whole = { about: { ...ABOUT, second }, low: 0, high: 20 }, scale = own.scale(whole), ground = own.ground(whole, 480, scale);
    for (const z of [0, 20, second]) assert.ok(ground - z * scale > 0 && ground - z * scale < 480, `${second}: ${z}`);
  }
});

test("what acts on the disc is drawn, and nothing else", () => {
  const count = (bias) => cone([{ about: { ...ABOUT, bias } }]).g.calls.filter((c) => c.strokeStyle === LIGHT.edge && c.name === "lineTo").length;
  const none = count("none");
  assert.deepEqual(["spring", "weight", "force", "beam"].map((bias) => count(bias) - none), [19, 1, 3, 41]);
  assert.equal(count("spring+weight") - none, 20);
});

test("what acts on the disc is where it acts: a weight hangs from it, a force pushes it up, a beam is clamped at the sides and holds its middle", () => {
  for (const height of [10, 20]) {
    const acting = (bias) => {
      const { own, g } = cone([{ about: { ...ABOUT, bias }, height }]), side = { about: ABOUT, low: 0, high: 20 }, scale = own.scale(side);
      const calls = g.calls.filter((c) => c.strokeStyle === LIGHT.edge && c.fillStyle === LIGHT.edge);
      return { points: calls.filter((c) => ["moveTo", "lineTo"].includes(c.name)).map((c) => c.args), blocks: calls.filter((c) => c.name === "roundRect").map((c) => c.args), disc: own.ground(side, 480, scale) - height * scale, wide: 30 * scale };
    };
    const weight = acting("weight"), force = acting("force"), beam = acting("beam"), spring = acting("spring"), middle = (640 - 46) / 4;
    const [[x, y, w]] = weight.blocks, ends = weight.points.map(([, py]) => py);
    assert.ok(near(x + w / 2, middle) && near(Math.min(...ends), weight.disc) && near(Math.max(...ends), y) && y > weight.disc);
    const [tail, tip, left, again, right] = force.points; // the barbs are on the side of the tail
    assert.ok(tip[1] < tail[1] && tip[1] > force.disc && close([tip], [again]) && near(tip[0], middle));
    assert.ok(left[0] < tip[0] && right[0] > tip[0] && [left, right].every(([, py]) => py > tip[1] && py < tail[1]));
    const base = Math.max(...spring.points.map(([, py]) => py)), shape = beam.points;
    assert.ok(near(Math.min(...spring.points.map(([, py]) => py)), spring.disc) && base > spring.disc);
    assert.ok(close([shape[0], shape[20], shape[40]], [[middle - beam.wide, base], [middle, beam.disc], [middle + beam.wide, base]]));
    assert.ok(near(shape[1][1] - shape[0][1], 0, 1) && near(shape[19][1], shape[20][1], 0.01)); // flat where it is clamped and held
  }
});

test("texts of the cone stay in the picture, also while the disc is pulled beyond it", () => {
  for (const height of [-400, -20, 0, 20, 400]) {
    const all = boxes(cone([{ height, heightText: `${height} mm`, bias: "spring" }]).g);
    assert.deepEqual([all.length, all.filter(([, left, top, right]) => left < 0 || top < 0 || right > 640)], [3, []], `${height}`);
  }
});

test("the rims are held at the films' planes, and the disc is as wide as the film leaves it", () => {
  for (const second of [null, 15]) {
    const about = { ...ABOUT, second, bias: "none" }, { own, g } = cone([{ about, height: 10 }]), side = { about, low: 0, high: 20 };
    const scale = own.scale(side), ground = own.ground(side, 480, scale), middle = (640 - 46) / 4;
    const blocks = g.calls.filter((c) => c.name === "roundRect" && [LIGHT.steel, LIGHT.edge].includes(c.fillStyle)).map(({ args: [x, y, w, h] }) => [x, x + w, y + h / 2]);
    const held = [[-1, 0], [1, 0], ...(second === null ? [] : [[-1, second], [1, second]])];
    for (const [sign, z] of held) assert.equal(blocks.filter(([left, right, y]) => left <= middle + sign * 30 * scale && right >= middle + sign * 30 * scale && near(y, ground - z * scale)).length, 1, `${sign} ${z}`);
    const [disc] = blocks.filter(([left, right]) => left < middle && right > middle);
    assert.ok(near((disc[0] + disc[1]) / 2, middle) && Math.abs(disc[1] - disc[0] - 2 * 8 * scale) < 8 && near(disc[2], ground - 10 * scale));
    assert.equal(blocks.length, held.length + 1);
  }
});

test("the trail fades with age", () => {
  const ages = cone([{ trail: [9, 8, 7, 6] }]).g.calls.filter((c) => c.name === "fillRect" && c.fillStyle === LIGHT.accent && c.args[3] === 2).map((c) => c.globalAlpha);
  assert.ok(ages.length === 4 && ages.every((alpha, k) => alpha > 0 && alpha < 1 && (!k || alpha < ages[k - 1])));
});

test("two settings stand side by side, named and in their colours", () => {
  const { g } = cone([{ heightText: "one" }, { heightText: "two", films: [4, 0] }]);
  const names = g.calls.filter((c) => c.name === "fillText" && ["A", "B"].includes(c.args[0]));
  assert.deepEqual(names.map((c) => [c.args[0], c.fillStyle]), [["A", LIGHT.a], ["B", LIGHT.b]]);
  const [[ax], [bx]] = names.map((c) => [c.args[1] + c.shift[0]]);
  assert.deepEqual([ax, bx], [160, 480]);
  const apart = texts(cone([{ name: "pump" }, { name: "soft film" }]).g);
  assert.ok(apart.includes("A pump, in its own scale") && apart.includes("B soft film, in its own scale"));
  assert.ok(texts(g).includes("one, 500 V") && texts(g).includes("two, 500 V"));
});

test("in perspective the upper of two films is seen through, and the lower is not, whichever is the second", () => {
  for (const second of [15, -15]) {
    const { g } = cone([{ about: { ...ABOUT, second }, films: [0, 4], height: second / 2 }, {}]), calls = g.calls.slice(0, g.calls.findIndex((c) => c.name === "restore"));
    const order = calls.filter((c) => c.name === "fill" && c.lineWidth === 0.7).map((c) => c.globalAlpha);
    assert.ok(order[0] === 1 && order.at(-1) < 1 && order.at(-1) > 0.4, `${second}: ${order.at(-1)}`);
  }
});

test("a second film is flat where its plane is, in its own colour", () => {
  const { own, g } = cone([{ about: { ...ABOUT, second: 15 }, films: [0, 4], height: 10 }]), side = { about: { ...ABOUT, second: 15 }, low: 0, high: 20 };
  const scale = own.scale(side), ground = own.ground(side, 480, scale), middle = (640 - 46) / 4;
  const lines = g.calls.filter((c) => ["moveTo", "lineTo"].includes(c.name) && c.strokeStyle === FILM[4] && c.lineWidth > 2).map((c) => c.args);
  assert.ok(lines.some((at) => close([at], [[middle + 30 * scale, ground - 15 * scale]])));
  assert.ok(lines.some((at) => close([at], [[middle + 8 * scale, ground - 10 * scale]])));
});

test("a film is drawn thinner where it is thinner, and brighter the stronger its field", () => {
  const line = (more) => cone([{ films: [0, 0], ...more }]).g.calls.find((c) => c.name === "lineTo" && c.lineCap === "round");
  const [usual, thin, dull, bright] = [line({}), line({ thin: [0.5], field: [0] }), line({ thin: [1], field: [0] }), line({ thin: [1], field: [1] })];
  assert.ok(near(thin.lineWidth, 0.5 * usual.lineWidth) && near(dull.lineWidth, usual.lineWidth));
  const light = ({ strokeStyle }) => [1, 3, 5].reduce((sum, k) => sum + parseInt(strokeStyle.slice(k, k + 2), 16), 0);
  assert.equal(dull.strokeStyle, LIGHT.taut);
  assert.ok(light(bright) > light(dull) + 100);
  assert.ok(near(line({ thin: [NaN], field: [NaN] }).lineWidth, usual.lineWidth));
});

test("a hand takes the disc and lets it go at its place, and the gauge; a frame of no size draws nothing wrong", () => {
  const done = [], { own } = cone([{ height: 10, trail: [9, 8] }]), { canvas } = own;
  own.hands = { disc: (height, settled) => done.push(["disc", height, settled]), volts: (share, settled) => done.push(["volts", share, settled]) };
  const [disc, gauge] = ["disc", "volts"].map((kind) => own.grips.find((grip) => grip.kind === kind));
  const put = (event, x, y, more = {}) => canvas[`on${event}`]({ type: event, clientX: x + 10, clientY: y + 20, pointerId: 1, ...more });
  const [x, y] = [(disc.box[0] + disc.box[2]) / 2, (disc.box[1] + disc.box[3]) / 2], scale = Math.abs(1 / (disc.value(1) - disc.value(0)));
  put("pointerdown", x, y + 3); put("pointermove", x, y + 4); put("pointermove", x, y + 3 - 5 * scale); put("pointerup", x, y + 3 - 6 * scale);
  assert.deepEqual(done.map(([kind, , settled]) => [kind, settled]), [["disc", false], ["disc", true]]); // not for a trembling hand
  assert.ok(near(done[0][1], 15, 1e-4) && near(done[1][1], 16, 1e-4));
  done.length = 0;
  put("pointerdown", x, y, { button: 2 }); put("pointermove", x, y - 50); put("pointerdown", 3, 3); put("pointermove", 3, 50); put("pointerup", 3, 50);
  assert.deepEqual(done, []);
  const quarter = 0.75 * gauge.box[1] + 0.25 * gauge.box[3]; // from the top of -1000 to 2000 V: 1250 V
  put("pointerdown", gauge.box[0] + 1, gauge.box[3]); put("pointermove", gauge.box[0], quarter); put("pointercancel", 0, 0);
  assert.deepEqual(done.map(([kind, share, settled]) => [kind, Number(share.toFixed(6)), settled]), [["volts", 0.625, false], ["volts", 0.625, true]]);
  done.length = 0; // below zero volts no voltage changes its sign
  put("pointerdown", gauge.box[0] + 1, quarter); put("pointermove", gauge.box[0], gauge.box[3]); put("pointerup", gauge.box[0], gauge.box[3]);
  assert.deepEqual(done, [["volts", 0, false], ["volts", 0, true]]);
  assert.ok(own.held === null);
  for (const [w, h, drawn] of [[20, 480, false], [0, 480, false], [640, 0, false], [640, 20, true]]) { // too narrow for the gauge, and too low for the texts
    Object.assign(own, { w, h }); forget(own.context);
    own.draw([{ about: ABOUT, height: 10, films: [0, 0], low: 0, high: 20, volts: [0, 100], voltage: 50, heightText: "", voltageText: "" }]);
    assert.equal(own.context.calls.some((c) => c.name === "ellipse"), drawn, `${w} ${h}`);
  }
});

test("in perspective the disc lies at its height, its upper face over its lower one", () => {
  for (const height of [0, 7, 20]) {
    const { own, g } = cone([{ height }, { height }]), calls = g.calls, rims = calls.filter((c) => c.name === "ellipse" && c.args[2] !== c.args[3]), tilt = rims[1].args[3] / rims[1].args[2];
    const side = { about: ABOUT, low: 0, high: 20 }, scale = own.scale(side), at = calls.findIndex((c, k) => c.name === "fill" && c.fillStyle === LIGHT.steel && calls[k - 1].name === "ellipse");
    const [upper, lower] = [calls[at - 1].args, calls[at - 4].args], y = own.ground(side, 480, scale) - height * scale * Math.sqrt(1 - tilt * tilt);
    assert.ok(near(tilt, 0.4) && near(upper[1], y, 1e-6) && near(upper[2], 8 * scale, 1e-6) && lower[1] > upper[1], `${height}`);
  }
});

test("each ring of a membrane is taut or wrinkled, but above breakdown or near its limit all of it has that colour", () => {
  const shape = [[8, 1, false], [20, 0.4, true], [30, 0, true]].map(([radius, rise, wrinkled]) => ({ radius, rise, stretch: 1, wrinkled }));
  for (const [film, states] of [[0, [0, 1]], [1, [0, 1]], [4, [4]], [5, [5]], [6, [6]]]) {
    const { g } = cone([{ films: [film, 0], shapes: [shape, null], field: [0, 0] }]);
    const drawn = FILM.map((colour) => g.calls.some((c) => c.name === "lineTo" && c.strokeStyle === colour && c.lineWidth > 1)).flatMap((found, k) => (found ? [k] : []));
    assert.deepEqual(drawn, states);
  }
});

test("the names of two settings stand below their cones, whatever the room", () => {
  for (const [w, h] of [[640, 480], [900, 260], [400, 700]]) {
    const { own } = cone([{}, {}]), g = own.context;
    Object.assign(own.canvas, { clientWidth: w, clientHeight: h }); own.fit(); forget(g);
    own.draw([{}, {}].map(() => ({ about: ABOUT, height: 10, films: [0, 0], low: 0, high: 20, volts: [0, 1], voltage: 0, heightText: "10 mm", voltageText: "0 V" })));
    const lowest = Math.max(...g.calls.filter((c) => c.name === "ellipse" && c.strokeStyle === LIGHT.steel).map((c) => c.args[1] + c.args[3] + c.lineWidth / 2)), names = boxes(g).filter(([text]) => ["A", "B"].includes(text));
    assert.equal(names.length, 2);
    for (const [text, , top] of names) assert.ok(top >= lowest, `${w} × ${h} ${text}: ${top} ${lowest}`);
  }
});

test("the cone is drawn as sharp as the screen", () => {
  for (const d of [1, 2]) {
    globalThis.devicePixelRatio = d;
    const { own, g } = cone([{}]);
    assert.deepEqual([own.canvas.width, own.canvas.height, g.calls.find((c) => c.name === "setTransform").args], [640 * d, 480 * d, [d, 0, 0, d, 0, 0]]);
  }
  globalThis.devicePixelRatio = 1;
});

test("the disc can be taken over its whole breadth", () => {
  const { own } = cone([{}]), scale = own.scale({ about: ABOUT, low: 0, high: 20 }), middle = (640 - 46) / 4, y = own.ground({ about: ABOUT, low: 0, high: 20 }, 480, scale) - 10 * scale;
  own.hands = { disc() {}, volts() {} };
  for (const [share, taken] of [[-1.5, false], [-0.9, true], [0, true], [0.9, true], [1.5, false]]) {
    own.canvas.onpointermove({ clientX: 10 + middle + share * 8 * scale, clientY: 20 + y, pointerId: 1, type: "pointermove" });
    assert.equal(own.canvas.style.cursor === "ns-resize", taken, `${share}`);
  }
});

test("each line is begun anew, so that none is drawn again in the colour of the next", () => {
  const shape = [[8, 1], [20, 0.4], [30, 0]].map(([radius, rise]) => ({ radius, rise, stretch: 1, wrinkled: false }));
  for (const film of FILM.keys()) for (const shapes of [[null, null], [shape, null]]) {
    let begun = false;
    for (const { name } of cone([{ films: [film, film], shapes, about: { ...ABOUT, second: 30 } }]).g.calls) {
      if (name === "beginPath") begun = true;
      if (name === "stroke") { assert.ok(begun, `${film}`); begun = false; }
    }
  }
});

test("the cone in section is drawn from its ground to the height of the disc, then in perspective, then the gauge", () => {
  const all = { ...ABOUT, bias: "spring weight force beam" }, styled = (sides) => drawn(cone(sides).g).filter((one) => !/rgb\(/.test(one)), rims = ["line steel 7", "area steel", "line steel 7"], shade = "area rgba(20,30,45,0.08)";
  const gauge = ["area field", "area accent", "500 V | soft 11px center middle", "voltage | soft 11px center middle"], held = ["line taut 5", "area steel", "box panel at 0.8", "10 mm | ink 600 12px center bottom"], begin = ["box panel", "line line 1 dashed 3,4"], bias = ["line edge 1.6", "area edge", "line edge 1.6"];
  assert.deepEqual(styled([{ about: all, trail: [9, 8] }]), [...begin, "box accent at 0.3", "box accent at 0.15", ...bias, ...held, shade, ...rims, ...gauge]);
  const other = ["line around 5 dashed 10,8", "area edge"];
  assert.deepEqual(styled([{ about: { ...all, second: 30 }, films: [0, 1] }]), [...begin, ...other, ...other, ...bias, ...held, shade, ...rims, "line steel 7 at 0.7", "area steel at 0.7", "line steel 7 at 0.7", ...gauge]);
  assert.deepEqual(styled([{ name: "one" }, { name: "two" }]), ["box panel", ...["A one", "B two"].flatMap((name, k) => [shade, ...rims, `${name}, in its own scale | ${"ab"[k]} 700 13px center bottom`, "10 mm, 500 V | ink 600 12px center bottom"])]);
});

test("in perspective a ring of a membrane is the brighter the more it is stretched, and none of one without a field", () => {
  const shape = [8, 11, 14, 20, 30].map((radius, k) => ({ radius, rise: 1 - k / 4, stretch: [4, 3, 2, 1.5, 1][k], wrinkled: false }));
  const light = (css) => css.match(/\d+/g).reduce((sum, v) => sum + Number(v), 0), drawnWith = (field) => {
    const { g } = cone([{ shapes: [shape, null], thin: [1, NaN], field: [field, 0] }, {}]), end = g.calls.findIndex((c) => c.name === "restore");
    return g.calls.slice(0, end).filter((c) => c.name === "fill" && /^rgb\(/.test(c.fillStyle)).map((c) => light(c.fillStyle)).slice(0, 2); // outer and inner ring of one sector
  };
  const [dull, bright] = [0, 0.9].map(drawnWith), more = bright.map((v, k) => v / dull[k]);
  assert.ok(more[0] > 1.02 && more[1] > 1.2 * more[0], `${more}`);
});

test("a film is never thinner than can be seen nor thicker than twice its own line, and its field brightens it up to breakdown", () => {
  const shape = [[8, 1], [30, 0]].map(([radius, rise]) => ({ radius, rise, stretch: 1, wrinkled: false }));
  for (const shapes of [[null, null], [shape, null]]) {
    const line = (thin, field) => cone([{ films: [0, 0], shapes, thin: [thin], field: [field] }]).g.calls.find((c) => c.name === "lineTo" && c.lineCap === "round");
    assert.deepEqual([0.01, 0.3, 0.6, 1.5, 2, 9, 0].map((thin) => line(thin, 0).lineWidth), [1.5, 1.5, 3, 7.5, 10, 10, 5]);
    const colours = [-1, 0, 0.5, 1, 7].map((field) => line(1, field).strokeStyle);
    assert.deepEqual([colours[0], colours[4]], [LIGHT.taut, colours[3]]);
    assert.equal(new Set(colours).size, 3);
  }
});

test("disc and gauge are taken hold of within 12 pixels", () => {
  const { own } = cone([{}]);
  own.hands = { disc() {}, volts() {} };
  for (const { box: [x0, y0, x1, y1] } of own.grips) for (const [by, taken] of [[11, true], [13, false]]) for (const [x, y] of [[x0 - by, (y0 + y1) / 2], [x1 + by, (y0 + y1) / 2], [(x0 + x1) / 2, y0 - by], [(x0 + x1) / 2, y1 + by]]) {
    own.canvas.onpointermove({ clientX: 10 + x, clientY: 20 + y, pointerId: 1, type: "pointermove" });
    assert.equal(own.canvas.style.cursor, taken ? "ns-resize" : "", `${x} ${y}`);
  }
  const [disc] = own.grips; // and are held however far the hand goes
  own.canvas.onpointerdown({ clientX: 10 + disc.box[0], clientY: 20 + disc.box[1], pointerId: 1, type: "pointerdown" });
  own.canvas.onpointermove({ clientX: 10, clientY: 20, pointerId: 1, type: "pointermove" });
  assert.equal(own.canvas.style.cursor, "ns-resize");
});

const channels = (css) => (css.startsWith("#") ? [1, 3, 5].map((k) => parseInt(css.slice(k, k + 2), 16)) : css.match(/\d+/g).map(Number));

test("the field brightens a film with its square, at breakdown to 55 % of the way to white, each ring by its own stretch", () => {
  const toWhite = (css) => { const [r, , b] = channels(css), [p, , q] = channels(LIGHT.taut); return ((r - p) / (255 - p) + (b - q) / (255 - q)) / 2; };
  const shape = (...stretches) => [[8, 1], [20, 0.4], [30, 0]].map(([radius, rise], k) => ({ radius, rise, stretch: stretches[k], wrinkled: false }));
  const lines = (field, shapes) => [...new Set(cone([{ thin: [1], field: [field], shapes }]).g.calls.filter((c) => c.name === "lineTo" && c.lineCap === "round").map((c) => c.strokeStyle))].map(toWhite);
  for (const field of [0.5, 0.9, 1]) {
    assert.ok(near(lines(field, [null, null])[0], 0.55 * field ** 2, 0.01), `${field}`);
    for (const [most, ...means] of [[shape(3, 2, 1), 2.5, 1.5], [shape(1, 3, 2), 2, 2.5]]) for (const [k, stretch] of means.entries()) assert.ok(near(lines(field, [most, null])[k], 0.55 * (field * (stretch / 3)) ** 2, 0.01), `${field} ${stretch}`);
  }
});

test("a facet is lit from the upper left, darker behind and in its pleats, and never black", () => {
  const { own } = cone([{}]), film = channels(LIGHT.taut), dark = channels("#12202c");
  const shade = (...facet) => { const [, g, b] = channels(own.shade(...facet)), [, p, q] = film; return ((p - g) / (p - dark[1]) + (q - b) / (q - dark[2])) / 2; };
  for (let angle = 0; angle < 6.3; angle += 0.7) for (const slope of [-0.8, 0, 0.8]) {
    const front = 0.5 * (1 - (0.5 + 0.5 * Math.cos(angle + 2.3) * Math.sin(slope + 0.5)));
    assert.ok(near(shade(0, angle, slope, 1, 1, true), front, 0.02) && near(shade(0, angle, slope, 1, 1, false), front + 0.12, 0.02), `${angle} ${slope}`);
  }
  const part = (film, sector, ring) => { const [, , b] = channels(own.shade(film, 1, 0.3, sector, ring, true)), p = channels(FILM[film])[2]; return (p - b) / (p - dark[2]); };
  for (const [film, sector, ring] of [[1, 1, 0], [2, 1, 1], [3, 1, 0], [3, 0, 1]]) assert.ok(near(part(film, sector, ring) - part(film, 0, 0), 0.2, 0.05), `${film}`);
  assert.ok(near(part(3, 1, 1) - part(3, 0, 0), 0.4, 0.05) && part(3, 1, 1) <= 0.81);
});

test("what is written about a cone stands in its place, and a long name in the room of its side", () => {
  const { own, g } = cone([{}]), at = (calls) => calls.filter((c) => c.name === "fillText").map(({ args: [text, x, y, most], shift }) => [text, x + shift[0], y, ...(most ? [most] : [])]), side = { about: ABOUT, low: 0, high: 20 };
  const disc = own.ground(side, 480, own.scale(side)) - 10 * own.scale(side);
  assert.deepEqual(at(g.calls), [["10 mm", (640 - 46) / 4, disc - 8], ["500 V", 640 - 46 + 4 - (640 - 46) / 2 + 23 - 4, 480 - 24 + 13], ["voltage", 640 - 46 + 4 - (640 - 46) / 2 + 23 - 4, 22 - 11]].map(([text, x, y]) => [text, x, y]));
  assert.deepEqual(at(cone([{ name: "n".repeat(90) }, { name: "m" }]).g.calls), [0, 1].flatMap((k) => [[`${"AB"[k]} ${k ? "m" : "n".repeat(90)}, in its own scale`, 160 + 320 * k, 480 - 18, 320 - 12], ["10 mm, 500 V", 160 + 320 * k, 480 - 3]]));
  const ground = g.calls.find((c) => c.name === "fillRect" && near(c.globalAlpha, 0.8)).args;
  assert.deepEqual(ground, [(640 - 46) / 4 - 15 - 3, disc - 8 - 14, 36, 15]);
});

test("a film that is slack around has dashes, and nothing that is drawn after it", () => {
  const dashed = (one) => drawn(cone([one]).g).filter((line) => line.startsWith("line") && line.includes("dashed")).map((line) => line.match(/dashed (\S+)/)[1]), ground = "3,4";
  for (const film of FILM.keys()) assert.deepEqual(dashed({ films: [film, 0] }), [ground, ...([1, 3].includes(film) ? ["10,8"] : [])], `${film}`);
  const shape = [[8, 1], [20, 0.4], [30, 0]].map(([radius, rise]) => ({ radius, rise, stretch: 1, wrinkled: true }));
  assert.deepEqual(dashed({ shapes: [shape, null] }), [ground, "3,5"]);
  assert.deepEqual([...new Set(dashed({ about: { ...ABOUT, second: 30 }, shapes: [null, shape] }))], [ground, "3,5"]);
  assert.ok(drawn(cone([{ about: { ...ABOUT, second: 30 }, shapes: [null, shape] }]).g).includes("line edge 1.6")); // the spring behind it
});

test("two settings of one subject have one scale, of two each its own", () => {
  const rims = (...names) => { const { g } = cone([{ name: names[0], high: 20 }, { name: names[1], high: 90 }]); return g.calls.filter((c) => c.name === "ellipse" && c.strokeStyle === LIGHT.steel).map((c) => c.args[2]); };
  assert.equal(new Set(rims("pump", "pump")).size, 1);
  assert.equal(new Set(rims("pump", "cone")).size, 2);
});

test("a cone is drawn as by one that has drawn nothing before, whatever it has drawn", () => {
  const ring = (radius, rise, wrinkled) => ({ radius, rise, stretch: 1.2, wrinkled }), shape = [ring(8, 1, true), ring(15, 0.4, true), ring(22, 0.2, false), ring(26, 0.1, false), ring(30, 0, false)];
  const pictures = [[{ name: "one" }, { name: "other" }], [{ films: [1, 0] }], [{ about: { ...ABOUT, second: 25, bias: "weight+beam" }, films: [3, 2], thin: [0.5, 0.7], field: [0.4, 0.9] }], [{ shapes: [shape], field: [0.5], name: "one" }, { films: [2, 2], name: "one" }], [{ trail: [1, 2, 3], height: -3, low: -4 }], [{ about: { ...ABOUT, bias: "force" }, volts: [0, 0], voltage: 0 }]];
  const { own, g } = cone([{}]);
  for (const sides of [...pictures, ...pictures.toReversed()]) {
    const fresh = cone(sides);
    fresh.g.calls.splice(0, fresh.g.calls.findIndex((c) => c.name === "setTransform")); // the ground of a canvas without a picture
    forget(g); own.draw(sides.map((side) => ({ about: ABOUT, height: 10, films: [0, 0], low: 0, high: 20, volts: [-1000, 2000], voltage: 500, heightText: "10 mm", voltageText: "500 V", ...side })));
    assert.deepEqual(g.calls.map(({ name, args }) => [name, args]), fresh.g.calls.map(({ name, args }) => [name, args]));
    assert.deepEqual(drawn(g), drawn(fresh.g));
    assert.deepEqual(own.grips.map(({ box }) => box), fresh.own.grips.map(({ box }) => box));
  }
});
