/** Shows what a name means beside it, while it is pointed at or has the focus. */
{
  const tip = document.getElementById("tip");
  let shown = null;
  const hide = () => {
    shown = null;
    tip.hidden = true;
  };
  const place = () => {
    if (!shown) return;
    const of = shown.getBoundingClientRect();
    const below = of.bottom + 6 + tip.offsetHeight <= innerHeight;
    tip.style.top = `${below ? of.bottom + 6 : Math.max(6, of.top - 6 - tip.offsetHeight)}px`;
    tip.style.left = `${Math.max(12, Math.min(of.left, document.documentElement.clientWidth - tip.offsetWidth - 12))}px`;
  };
  const show = ({ currentTarget: name }) => {
    shown = name;
    tip.replaceChildren(...name.querySelector("small").cloneNode(true).childNodes);
    tip.hidden = false;
    place();
  };
  for (const name of document.querySelectorAll(".def")) {
    name.addEventListener("pointerenter", show);
    name.addEventListener("focus", show);
    name.addEventListener("pointerleave", hide);
    name.addEventListener("blur", hide);
  }
  document.addEventListener("keydown", (event) => event.key === "Escape" && hide());
  document.addEventListener("scroll", place, { capture: true, passive: true });
}
