// The numbers of the scene's materials: shows them by name, changes them one at a time, resets them to the file, and
// prints materials as XML.
"use strict";

let material = null;       // the one shown, as the server sent it
let materialsShown = -1;   // state.materials when the list was last fetched

// Words for parameters that scenes name by a symbol or an abbreviation.
const numberWords = {
  kd: "diffuse reflectance", int_ior: "index inside", ext_ior: "index outside", ior: "index of refraction", k: "absorption k", eta: "index eta",
  alpha: "roughness alpha", alpha_u: "roughness alpha u", alpha_v: "roughness alpha v", spec_trans: "transmission", spec_tint: "highlight tint",
  diff_trans: "diffuse transmission", normals: "normal map", height: "bump height",
};
const wordOf = (name) => numberWords[name] || name.replaceAll("_", " ");
// Numbers between 0 and 1 in every material, which get a slider; the others have no upper limit.
const isShare = (number) => !["int_ior", "ext_ior", "ior", "eta", "k", "height", "iridescence_ior", "iridescence_thickness", "anisotropy_rotation", "dispersion",
  "attenuation_distance", "diff_trans"].includes(number.name);
const shortNumber = (v) => v === null ? "inf" : String(+v.toPrecision(7));
const shortValue = (number, value) => number.color ? value.map(shortNumber).join(", ") : shortNumber(value);
const sameValue = (a, b) => String(a) === String(b);

// Converts linear light to the browser's colour picker and back.
const decoded = (x) => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
const hexOf = (value) => "#" + value.map((v) => Math.round(255 * encode(Math.max(0, Math.min(1, v)))).toString(16).padStart(2, "0")).join("");
const lightOf = (hex) => [1, 3, 5].map((at) => +decoded(parseInt(hex.slice(at, at + 2), 16) / 255).toPrecision(6));

// --- asking -----------------------------------------------------------------------------------------------------------------

// Sends one request at a time; of those wanted meanwhile, only the last is sent.
let fetching = false, fetchAgain = false;
async function followMaterials() {
  if (state.materials === materialsShown) return;
  if (fetching) { fetchAgain = true; return; }
  fetching = true;
  try {
    do {
      fetchAgain = false;
      const counted = state.materials;
      showList(await ask("materials", {}));
      await showMaterial();
      materialsShown = counted;
    } while (fetchAgain);
  } catch { /* follow() reports a lost connection */ }
  fetching = false;
}

function showList({ count, materials }) {
  $("materials").hidden = count === 0;
  const select = $("material"), chosen = Math.min(+select.value || 0, Math.max(0, materials.length - 1));
  const texts = materials.map((m, row) => `${row + 1}  ${m.name === m.type ? m.type : `${m.name} (${m.type})`}${m.changed ? ", changed" : ""}`);
  if (select.options.length !== texts.length) {
    select.replaceChildren(...texts.map((text, row) => new Option(text, row)));
  } else {
    for (const [row, text] of texts.entries()) if (select.options[row].text !== text) select.options[row].text = text;
  }
  select.value = chosen;
  $("material-more").hidden = count === materials.length;
  $("material-more").textContent = `The first ${materials.length} of ${count}.`;
}

async function showMaterial() {
  if ($("materials").hidden) return;
  const next = await ask("material", { row: $("material").value });
  const same = material && material.row === next.row && String(material.numbers.map((n) => n.name)) === String(next.numbers.map((n) => n.name));
  material = next;
  if (!same) buildNumbers();
  fillNumbers();
  if ($("material-text").value) showMaterialText();
}

// --- controls ---------------------------------------------------------------------------------------------------------------

function element(tag, attributes, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

function controlsOf(number) {
  const id = `number-${number.name}`, word = wordOf(number.name), label = element("label", { for: id }, word);
  if (number.texture !== null) return [label, element("output", { id, class: "texture" }, `texture ${number.texture}`)];
  const box = element("span", { class: "number" });
  if (number.color) {
    const picker = element("input", { type: "color", id: `${id}-picker`, "aria-label": `${word}, colour picker` });
    for (const [event, moving] of [["input", 1], ["change", 0]]) picker.addEventListener(event, () => sendNumber(number.name, lightOf(picker.value).join(), moving));
    box.append(picker);
  } else if (isShare(number)) {
    const slider = element("input", { type: "range", id: `${id}-slider`, min: 0, max: 1, step: 0.005, "aria-label": `${word}, slider` });
    for (const [event, moving] of [["input", 1], ["change", 0]]) slider.addEventListener(event, () => sendNumber(number.name, slider.value, moving));
    box.append(slider);
  }
  const field = element("input", { type: "text", inputmode: "decimal", id, "aria-describedby": "material-problem", spellcheck: "false",
    title: number.color ? "red, green, blue: linear light" : "" });
  field.addEventListener("change", () => sendNumber(number.name, field.value.trim().replace(/[\s;,]+/g, ","), 0));
  const undo = element("button", { type: "button", class: "undo", id: `${id}-undo`, "aria-label": `reset ${word} to the file's value`, title: "reset to the file's value" }, "↺");
  undo.addEventListener("click", () => sendNumber(number.name, null, 0));
  box.append(field, undo);
  return [label, box];
}

function buildNumbers() {
  const note = material.numbers.length === 0 ? [element("p", {}, "This material has no numbers.")] : [];
  $("numbers").replaceChildren(...material.numbers.flatMap(controlsOf), ...note);
  materialProblem("");
}

function fillNumbers() {
  for (const number of material.numbers) {
    if (number.texture !== null) continue;
    const id = `number-${number.name}`;
    if ($(id).getAttribute("aria-invalid") !== "true") fill(id, shortValue(number, number.value));
    if (number.color && document.activeElement !== $(`${id}-picker`)) $(`${id}-picker`).value = hexOf(number.value);
    if ($(`${id}-slider`)) fill(`${id}-slider`, number.value);
    $(`${id}-undo`).disabled = sameValue(number.value, number.own);
  }
  $("material-own").disabled = material.numbers.every((n) => sameValue(n.value, n.own));
}

function materialProblem(sentence, name) {
  $("material-problem").hidden = !sentence;
  $("material-problem").textContent = sentence;
  for (const field of $("numbers").querySelectorAll("[aria-invalid]")) field.removeAttribute("aria-invalid");
  if (sentence && name) $(`number-${name}`).setAttribute("aria-invalid", "true");
}

// --- changing ---------------------------------------------------------------------------------------------------------------

let numberWaits = null, numberSends = false;
async function sendNumber(name, value, moving) {
  numberWaits = { row: material.row, ...(name ? { name } : {}), ...(value === null ? {} : { value }), moving };
  if (numberSends) return;
  numberSends = true;
  while (numberWaits) {
    const sent = numberWaits;
    numberWaits = null;
    try {
      const answer = await fetch(`material?${new URLSearchParams(sent)}`, { method: "POST" });
      materialProblem(answer.ok ? "" : (await answer.text()).trim(), sent.name);
      if (answer.ok && sent.name && !sent.moving) $("announcer").textContent = `${wordOf(sent.name)} ${sent.value === undefined ? "reset to the file's value" : sent.value}.`;
    } catch { break; }  // follow() reports a lost connection
  }
  numberSends = false;
}

$("material").addEventListener("change", () => showMaterial().catch(() => {}));
$("material-own").addEventListener("click", () => sendNumber("", null, 0));

// Called after a click on the picture.
async function chooseMaterial(row) {
  if (row >= $("material").options.length) return;
  $("material").value = row;
  await showMaterial();
  $("announcer").textContent = `Material ${$("material").selectedOptions[0].text}.`;
  $("materials").scrollIntoView({ block: "nearest" });
}

async function showMaterialText() {
  const answer = await fetch(`material.xml?${new URLSearchParams({ row: $("material").value, dialect: $("material-dialect").value })}`);
  $("material-text").value = (await answer.text()).trimEnd();
  return answer.ok;
}
$("material-show").addEventListener("click", showMaterialText);
$("material-dialect").addEventListener("change", showMaterialText);
$("material-copy").addEventListener("click", async () => {
  if (await showMaterialText()) copyText("material-text", "The material");
});
