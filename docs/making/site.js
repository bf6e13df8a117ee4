// What scrolls sideways can be reached, and scrolled, by the keyboard.
const reachable = () => {
  for (const one of document.querySelectorAll(".md-typeset pre > code, .md-typeset__scrollwrap")) {
    if (one.scrollWidth > one.clientWidth) one.tabIndex = 0;
    else one.removeAttribute("tabindex");
  }
};
addEventListener("load", () => requestAnimationFrame(reachable));
addEventListener("resize", reachable);
