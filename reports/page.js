// Without this script the page lacks three buttons, and nothing else.
(() => {
  const claims = () => document.querySelectorAll("details.claim");
  const openAll = (open) => claims().forEach((claim) => { claim.open = open; });
  const reveal = () => {
    const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (target && target.matches("details")) { target.open = true; target.scrollIntoView(); }
  };
  const bar = document.getElementById("controls");
  if (bar) {
    bar.hidden = false;
    bar.querySelector("[data-do=open]").addEventListener("click", () => openAll(true));
    bar.querySelector("[data-do=close]").addEventListener("click", () => openAll(false));
    const only = bar.querySelector("[data-do=only]");
    only.addEventListener("click", () => {
      const on = document.body.classList.toggle("only-failures");
      only.setAttribute("aria-pressed", String(on));
    });
  }
  let closed = [];
  addEventListener("beforeprint", () => {
    closed = [...claims()].filter((claim) => !claim.open);
    openAll(true);
  });
  addEventListener("afterprint", () => closed.forEach((claim) => { claim.open = false; }));
  addEventListener("hashchange", reveal);
  reveal();
})();
