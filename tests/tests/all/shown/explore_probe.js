// Renders with the page at some settings and posts the planes to the parent frame as JSON.
addEventListener("load", async () => {
  await airr.ready;
  const text = (floats) => {
    const bytes = new Uint8Array(floats.buffer, floats.byteOffset, floats.byteLength);
    return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
  };
  // The facts that the page shows at some settings, some of which stand in boxes.
  const shown = async (changed) => {
    for (const [key, value] of Object.entries(changed)) {
      if (key in airr.state) airr.state[key] = value;
      else if (key !== "azimuth") document.getElementById(key).value = value;
    }
    document.getElementById("ambient").dispatchEvent(new Event("input"));
    await new Promise((done) => setTimeout(done, 100));
    const facts = document.querySelectorAll("[id^=fact-]");
    return Object.fromEntries([...facts].map((e) => [e.id.slice(5), e.textContent]));
  };
  const images = [];
  for (const changed of SETTINGS) {
    const own = airr.settings({ ...airr.state, ...changed });
    const { planes, pitch, energy } = airr.render(changed);
    const facts = await shown(changed);
    images.push({ own, pitch, energy, planes: planes.map(text), facts });
  }
  document.getElementById("foreign")?.click();
  const quick = airr.render(SETTINGS[0], false).planes.length;
  // A slider that is moved changes the words.
  const slider = document.getElementById("s-distance");
  slider.value = 990;
  slider.dispatchEvent(new Event("input"));
  slider.dispatchEvent(new Event("change"));
  await new Promise((done) => setTimeout(done, 500));
  // A typed number moves the slider, and is kept within its range.
  const exact = document.getElementById("n-incidence");
  const typed = ["12.5", "1e9", "none"].map((text) => {
    exact.value = text;
    exact.dispatchEvent(new Event("change"));
    return Number(exact.value);
  });
  // The pictures grow, are saved with a caption, and a dropped one shows its name.
  const box = (e) => e.getBoundingClientRect();
  const aerial = document.getElementById("aerial");
  const [saved, small] = [airr.save(), box(aerial).width];
  document.getElementById("larger").click();
  const grown = box(aerial).width / small;
  document.getElementById("larger").click();
  const name = "a sign of my own.png";
  const blob = await new Promise((done) => document.getElementById("source").toBlob(done));
  const drop = new Event("drop");
  drop.dataTransfer = { files: [new File([blob], name, { type: "image/png" })] };
  dispatchEvent(drop);
  // Decoding takes as long as it takes, and virtual time does not wait for it. A page whose time is
  // over posts nothing, and is opened again.
  let chosen = "";
  while (chosen !== name) {
    await new Promise((done) => setTimeout(done, 50));
    chosen = document.getElementById("choice").selectedOptions[0].textContent;
  }
  const wide = [...document.body.querySelectorAll("*")]
    .filter((e) => e.tagName !== "OPTION" && box(e).right > innerWidth + 0.5);
  const named = [...document.querySelectorAll("input, select, button")].filter(
    (e) => !(e.labels?.length || e.getAttribute("aria-label") || e.textContent.trim()),
  );
  const figures = {
    errors: ERRORS,
    blocked: BLOCKED,
    fetched: performance.getEntriesByType("resource").map((e) => e.name.slice(0, 30)),
    wide: wide.map((e) => `${e.tagName}.${e.className}#${e.id}`),
    unnamed: named.map((e) => e.id),
    saved: [saved.width > 2 * aerial.width, saved.height > aerial.height],
    grown,
    dropped: chosen === name,
    remarks: document.getElementById("remarks").textContent,
    spoken: slider.getAttribute("aria-valuetext"),
    curves: document.querySelectorAll("#curves polyline").length,
    bands: document.querySelectorAll("#curves polygon").length,
    typed,
    quick,
    images,
  };
  parent.postMessage(JSON.stringify(figures), "*");
});
