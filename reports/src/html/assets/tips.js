/** Shows what a name means beside it, while it is pointed at or has the focus. */
{
  const tip = document.getElementById("tip");
  const hide = () => (tip.hidden = true);
  const show = ({ currentTarget: name }) => {
    tip.replaceChildren(...name.querySelector("small").cloneNode(true).childNodes);
    tip.hidden = false;
    const of = name.getBoundingClientRect();
    const below = of.bottom + 6 + tip.offsetHeight <= innerHeight;
    tip.style.top = `${below ? of.bottom + 6 : Math.max(6, of.top - 6 - tip.offsetHeight)}px`;
    tip.style.left = `${Math.max(12, Math.min(of.left, document.documentElement.clientWidth - tip.offsetWidth - 12))}px`;
  };
  for (const name of document.querySelectorAll(".def")) {
    name.addEventListener("pointerenter", show);
    name.addEventListener("focus", show);
    name.addEventListener("pointerleave", hide);
    name.addEventListener("blur", hide);
  }
  document.addEventListener("keydown", (event) => event.key === "Escape" && hide());
  document.addEventListener("scroll", hide, { passive: true });
}
