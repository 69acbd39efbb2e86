// Without this script the page lacks its search, and nothing else; player.js is what turns scenes.
(() => {
  const claims = [...document.querySelectorAll("details.claim")];
  const families = [...document.querySelectorAll("details.family")];
  const rooms = document.querySelectorAll("div.room");
  const homes = new Map(claims.map((claim) => [claim, claim.parentElement]));
  const words = new Map(claims.map((claim) => [claim, `${claim.textContent} ${homes.get(claim).firstElementChild.textContent}`.toLowerCase()]));
  const find = document.getElementById("find");
  const sorted = document.getElementById("sorted");

  // What people type, and what claims say: any word of a line finds what has another.
  const alike = [
    ["tunnel", "through", "pass"], ["collision", "contact", "touch"], ["bounc", "restitution"], ["momentum", "impulse"],
    ["stack", "pile", "tower"], ["parallel", "thread"], ["determinis", "same bits"], ["inflat", "gas", "pressure"],
    ["fluid", "liquid", "water"], ["fracture", "tear"], ["hull", "convex"], ["speed", "timing", "cost"],
  ];
  const meanings = (word) => [word, ...alike.filter((stems) => stems.some((stem) => word.startsWith(stem))).flat()];

  // What is looked for is in the address, "#find=words&verdict=fails", so that it can be sent and kept.
  const boxes = () => ({ find: find.querySelector("[type=search]"), verdict: find.querySelectorAll("select")[0], kind: find.querySelectorAll("select")[1] });
  const keep = () => {
    const set = Object.entries(boxes()).filter(([name, box]) => box.value || name === "find").map(([name, box]) => [name, box.value]);
    location.replace(`#${new URLSearchParams(set)}`);
  };
  const recall = () => {
    const kept = new URLSearchParams(location.hash.slice(1));
    for (const [name, box] of Object.entries(boxes())) if (box.value !== (kept.get(name) ?? "")) box.value = kept.get(name) ?? "";
    search();
  };

  const reveal = () => {
    if (find && location.hash.startsWith("#find=")) { recall(); return; }
    const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target || !target.matches("details")) return;
    target.hidden = false;
    for (let each = target; each; each = each.parentElement.closest("details")) { each.hidden = false; each.open = true; }
    target.scrollIntoView();
  };

  const search = () => {
    const [verdict, kind] = [...find.querySelectorAll("select")].map((select) => select.value);
    const wanted = find.querySelector("[type=search]").value.toLowerCase().split(/\s+/).filter(Boolean);
    const inOrder = find.querySelector("[data-do=sort]").checked;
    let found = 0;
    for (const claim of claims) {
      const fits = (!verdict || claim.dataset.verdict === verdict) && (!kind || claim.dataset.kind === kind)
        && wanted.every((word) => meanings(word).some((each) => words.get(claim).includes(each)));
      claim.hidden = !fits;
      found += fits;
    }
    const ratio = (claim) => Number(claim.dataset.ratio ?? -1);
    for (const claim of inOrder ? [...claims].sort((a, b) => ratio(b) - ratio(a)) : claims) {
      (inOrder ? sorted : homes.get(claim)).append(claim);
    }
    const narrowed = Boolean(verdict || kind || wanted.length);
    for (const family of families) {
      const some = claims.some((claim) => homes.get(claim) === family && !claim.hidden);
      family.hidden = inOrder || !some;
      if (narrowed && some) family.open = true;
    }
    for (const room of rooms) room.hidden = !room.querySelector("details.family:not([hidden])");
    find.querySelector("output").textContent = narrowed ? `${found} of ${claims.length} claims` : "";
  };

  if (find) {
    find.hidden = false;
    find.addEventListener("input", () => { search(); keep(); });
    find.addEventListener("submit", (event) => event.preventDefault());
    const openAll = (open) => [...families, ...claims].forEach((each) => { each.open = open; });
    find.querySelector("[data-do=open]").addEventListener("click", () => openAll(true));
    find.querySelector("[data-do=close]").addEventListener("click", () => openAll(false));
  }
  let closed = [];
  addEventListener("beforeprint", () => {
    closed = [...document.querySelectorAll("details")].filter((each) => !each.open);
    closed.forEach((each) => { each.open = true; });
  });
  addEventListener("afterprint", () => closed.forEach((each) => { each.open = false; }));
  addEventListener("hashchange", reveal);
  reveal();
})();
