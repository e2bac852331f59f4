// Renders with the page at some settings and posts the planes to the parent frame as JSON.
addEventListener("load", async () => {
  await airr.ready;
  const text = (floats) => {
    const bytes = new Uint8Array(floats.buffer, floats.byteOffset, floats.byteLength);
    return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
  };
  const images = SETTINGS.map((changed) => {
    const own = airr.settings({ ...airr.state, ...changed });
    const { planes, pitch, energy } = airr.render(changed);
    return { own, pitch, energy, planes: planes.map(text) };
  });
  const quick = airr.render(SETTINGS[0], false).planes.length;
  // A slider that is moved changes the picture, the numbers and the words.
  const facts = () => [...document.querySelectorAll("dd")].map((e) => e.textContent).join("; ");
  const before = facts();
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
  const box = (e) => e.getBoundingClientRect();
  const wide = [...document.body.querySelectorAll("*")]
    .filter((e) => e.tagName !== "OPTION" && box(e).right > innerWidth + 0.5);
  const named = [...document.querySelectorAll("input, select, button")].filter(
    (e) => !(e.labels?.length || e.getAttribute("aria-label") || e.textContent.trim()),
  );
  const figures = {
    errors: ERRORS,
    fetched: performance.getEntriesByType("resource").map((e) => e.name.slice(0, 30)),
    wide: wide.map((e) => `${e.tagName}.${e.className}#${e.id}`),
    unnamed: named.map((e) => e.id),
    before,
    after: facts(),
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
