// Controls for the parameters of a scene.

/**
 * Shows controls for the parameters of a scene, in place of those that are there.
 * @param {HTMLElement} form
 * @param {import("./web_scene.mjs").Scene} scene
 * @param {(text: string) => void} say says what is wrong, or nothing
 */
export function showParameters(form, scene, say) {
  for (const group of form.querySelectorAll("details")) group.remove();
  /** @type {Map<string, HTMLElement>} */
  const groups = new Map();
  for (const parameter of scene.parameters) {
    const controls = controlsOf(parameter, (values) => {
      try {
        scene.set(parameter.section, parameter.path, values);
        say("");
      } catch (error) {
        say(String(error));
      }
    });
    if (controls.length === 0) continue;
    let group = groups.get(parameter.section);
    if (!group) {
      group = document.createElement("details");
      const title = document.createElement("summary");
      title.textContent = parameter.title;
      group.append(title);
      groups.set(parameter.section, group);
      form.append(group);
    }
    const label = document.createElement("label");
    label.title = parameter.meaning;
    label.append(`${parameter.path}${parameter.unit ? ` [${parameter.unit}]` : ""} `, ...controls);
    group.append(label);
  }
}

/**
 * @param {import("./web_scene.mjs").Parameter} parameter
 * @param {(values: number[]) => void} change
 * @returns {HTMLElement[]} none for curves
 */
export function controlsOf({ type, slider, choices, value }, change) {
  if (type === "curve") return [];
  if (type === "bool") {
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = value !== 0;
    box.addEventListener("change", () => change([box.checked ? 1 : 0]));
    return [box];
  }
  if (type === "choice") {
    const list = document.createElement("select");
    choices.forEach((choice, i) => list.append(new Option(choice, String(i), false, i === value)));
    list.addEventListener("change", () => change([list.selectedIndex]));
    return [list];
  }
  const values = Array.isArray(value) ? [...value] : [value];
  const numbers = document.createElement("output");
  const show = () => (numbers.value = values.map((one) => Number(one.toPrecision(3))).join(", "));
  show();
  const ranges = values.map((one, i) => {
    const range = document.createElement("input");
    range.type = "range";
    const { position, valueAt } = scaleOf(slider, type === "count");
    range.min = "0";
    range.max = "1";
    range.step = "0.001";
    range.value = String(position(one));
    range.addEventListener("input", () => {
      values[i] = valueAt(Number(range.value));
      show();
      change(values);
    });
    return range;
  });
  return [numbers, ...ranges];
}

/**
 * @param {[number, number, number]} slider from, to, whether logarithmic
 * @param {boolean} isWhole
 */
export function scaleOf([low, high, isLog], isWhole) {
  const log = isLog && low > 0;
  const at = (/** @type {number} */ share) =>
    log ? low * (high / low) ** share : low + (high - low) * share;
  return {
    valueAt: (/** @type {number} */ share) => (isWhole ? Math.round(at(share)) : at(share)),
    position: (/** @type {number} */ value) =>
      log ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low),
  };
}
