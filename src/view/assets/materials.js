// The numbers of the scene's materials and lights: shows them by name, changes them one at a time, resets them to the file,
// and prints materials as XML.
"use strict";

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

// The brightness of a light is a slider of stops above the file's: its largest component doubles with each. A black light has nothing to double.
const largestOf = (number, value) => number.color ? Math.max(...value) : value;
const kMostStops = 8;
const stopsOf = (number) => Math.log2(largestOf(number, number.value) / (largestOf(number, number.own) || 1));
const atStops = (number, stops) => {
  const to = (largestOf(number, number.own) || 1) * 2 ** stops, now = largestOf(number, number.value);
  if (!number.color) return to;
  return number.value.map((v) => +(now > 0 ? v / now * to : to).toPrecision(7));
};

function element(tag, attributes, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// A list of the scene, the numbers of the row that is chosen, and what the server says of a value. `kind` is "material" or "light": the ids of the
// elements begin with it, the server's answers are named by it, and its plural counts the changes in `state`.
class NumberPanel {
  constructor(kind, prefix) {
    Object.assign(this, { kind, list: `${kind}s`, prefix, row: null, shown: -1, fetching: false, again: false, waits: null, sends: false });
    $(kind).addEventListener("change", () => this.show().catch(() => {}));
    $(`${kind}-own`).addEventListener("click", () => this.send("", null, 0));
  }

  // Whether the page shows what the server has.
  get current() { return this.shown === state[this.list] && !this.sends; }

  // Sends one request at a time; of those wanted meanwhile, only the last is sent.
  async follow() {
    if (state[this.list] === this.shown) return;
    if (this.fetching) { this.again = true; return; }
    this.fetching = true;
    try {
      do {
        this.again = false;
        const counted = state[this.list];
        this.showList(await ask(this.list, {}));
        await this.show();
        this.shown = counted;
      } while (this.again);
    } catch { /* follow() reports a lost connection */ }
    this.fetching = false;
  }

  showList({ count, rows }) {
    $(this.list).hidden = count === 0;
    const select = $(this.kind), chosen = select.value;
    const words = rows.map((r, i) => ({ row: r.row ?? i, text: `${(r.row ?? i) + 1}  ${r.name === r.type || !r.name ? r.type : `${r.name} (${r.type})`}${r.changed ? ", changed" : ""}` }));
    if (select.options.length !== words.length) {
      select.replaceChildren(...words.map(({ row, text }) => new Option(text, row)));
    } else {
      for (const [i, { row, text }] of words.entries()) if (select.options[i].text !== text) Object.assign(select.options[i], { text, value: row });
    }
    if ([...select.options].some((option) => option.value === chosen)) select.value = chosen;
    else if (select.options.length > 0) select.selectedIndex = 0;
    $(`${this.kind}-more`).hidden = count === rows.length;
    $(`${this.kind}-more`).textContent = `${rows.length} of ${count} are listed.`;
  }

  async show() {
    if ($(this.list).hidden) return;
    const next = await ask(this.kind, { row: $(this.kind).value });
    const names = (of) => JSON.stringify(of.numbers.map((n) => [n.name, n.texture, n.fixed]));
    const same = this.row && this.row.row === next.row && names(this.row) === names(next);
    this.row = next;
    if (!same) this.build();
    this.fill();
    if (this.kind === "material" && $("material-text").value) showMaterialText();
  }

  async choose(row) {
    if (![...$(this.kind).options].some((option) => +option.value === row)) return false;
    $(this.kind).value = row;
    await this.show();
    return true;
  }

  // --- controls -----------------------------------------------------------------------------------------------------------

  controlsOf(number) {
    const id = this.prefix + number.name, word = wordOf(number.name), label = element("label", { for: id }, word), light = this.kind === "light";
    if (number.fixed) return [label, element("output", { id, class: "texture" }, `texture ${number.texture}`)];
    const box = element("span", { class: "number" });
    const on = (control, what) => {
      for (const [event, moving] of [["input", 1], ["change", 0]]) control.addEventListener(event, () => this.send(number.name, what(this.now(number.name)), moving));
      return control;
    };
    if (number.color) {
      const picker = element("input", { type: "color", id: `${id}-picker`, "aria-label": `${word}, colour picker` });
      box.append(on(picker, (now) => (light ? this.hueOf(picker, now) : lightOf(picker.value)).join()));
    } else if (!light && isShare(number)) {
      const slider = element("input", { type: "range", id: `${id}-slider`, min: 0, max: 1, step: 0.005, "aria-label": `${word}, slider` });
      box.append(on(slider, () => slider.value));
    }
    const field = element("input", { type: "text", inputmode: "decimal", id, "aria-describedby": `${this.kind}-problem`, spellcheck: "false",
      title: number.color ? "red, green, blue: linear light" : "" });
    field.addEventListener("change", () => this.send(number.name, field.value.trim().replace(/[\s;,]+/g, ","), 0));
    const undo = element("button", { type: "button", class: "undo", id: `${id}-undo`, "aria-label": `reset ${word} to the file's value`, title: "reset to the file's value" }, "↺");
    undo.addEventListener("click", () => this.send(number.name, null, 0));
    box.append(field, undo);
    const more = light ? this.brightness(id, word, on) : [];
    if (number.texture !== null) more.push(element("p", {}, `times the texture ${number.texture}`));
    return [label, box, ...more];
  }

  brightness(id, word, on) {
    const slider = element("input", { type: "range", id: `${id}-slider`, min: -kMostStops, max: kMostStops, step: 0.25, "aria-label": `${word}, stops above the file's` });
    on(slider, (now) => String(atStops(now, +slider.value)));
    return [element("label", { for: slider.id }, "stops"), element("span", { class: "slider" }, slider, element("output", { id: `${id}-stops`, for: slider.id }))];
  }

  now(name) { return this.row.numbers.find((n) => n.name === name); }

  // The colour that was picked, as bright as before.
  hueOf(picker, now) {
    const hue = lightOf(picker.value), most = Math.max(...hue), bright = largestOf(now, now.value) || 1;
    return hue.map((v) => +(most > 0 ? v / most * bright : 0).toPrecision(7));
  }

  build() {
    const note = this.row.numbers.length === 0 ? [element("p", {}, `This ${this.kind} has no numbers.`)] : [];
    $(`${this.kind}-numbers`).replaceChildren(...this.row.numbers.flatMap((number) => this.controlsOf(number)), ...note);
    this.problem("");
  }

  fill() {
    for (const number of this.row.numbers) {
      if (number.fixed) continue;
      const id = this.prefix + number.name, picker = $(`${id}-picker`), slider = $(`${id}-slider`), light = this.kind === "light";
      if ($(id).getAttribute("aria-invalid") !== "true") fill(id, shortValue(number, number.value));
      if (picker && document.activeElement !== picker) {
        const most = light ? largestOf(number, number.value) || 1 : 1;
        picker.value = hexOf(number.value.map((v) => v / most));
      }
      if (slider && light) {
        const stops = stopsOf(number), word = stops === -Infinity ? "black" : (stops > 0 ? "+" : "") + +stops.toFixed(2);
        fill(`${id}-slider`, Math.max(-kMostStops, Math.min(kMostStops, stops)));
        slider.setAttribute("aria-valuetext", stops === -Infinity ? word : `${word} stops`);
        $(`${id}-stops`).textContent = word;
      } else if (slider) {
        fill(`${id}-slider`, number.value);
      }
      $(`${id}-undo`).disabled = sameValue(number.value, number.own);
    }
    $(`${this.kind}-own`).disabled = this.row.numbers.every((n) => sameValue(n.value, n.own));
  }

  problem(sentence, name) {
    const box = $(`${this.kind}-problem`);
    box.hidden = !sentence;
    box.textContent = sentence;
    for (const field of $(`${this.kind}-numbers`).querySelectorAll("[aria-invalid]")) field.removeAttribute("aria-invalid");
    const field = name && $(this.prefix + name);
    if (sentence && field) field.setAttribute("aria-invalid", "true");
  }

  // --- changing -----------------------------------------------------------------------------------------------------------

  async send(name, value, moving) {
    this.waits = { row: this.row.row, ...(name ? { name } : {}), ...(value === null ? {} : { value }), moving };
    if (this.sends) return;
    this.sends = true;
    while (this.waits) {
      const sent = this.waits;
      this.waits = null;
      try {
        const answer = await fetch(`${this.kind}?${new URLSearchParams(sent)}`, { method: "POST" });
        this.problem(answer.ok ? "" : (await answer.text()).trim(), sent.name);
        if (answer.ok && sent.name && !sent.moving) $("announcer").textContent = `${wordOf(sent.name)} ${sent.value === undefined ? "reset to the file's value" : sent.value}.`;
      } catch { break; }  // follow() reports a lost connection
    }
    this.sends = false;
  }
}

const materialPanel = new NumberPanel("material", "number-"), lightPanel = new NumberPanel("light", "light-number-");

function followNumbers() {
  materialPanel.follow();
  lightPanel.follow();
}

// Called after a click on the picture: the material there, and the light if the surface is a lamp.
async function choosePoint({ material, light }) {
  if (!await materialPanel.choose(material)) return;
  const lamp = light !== null && await lightPanel.choose(light);
  $("announcer").textContent = `Material ${$("material").selectedOptions[0].text}${lamp ? `, light ${$("light").selectedOptions[0].text}` : ""}.`;
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
