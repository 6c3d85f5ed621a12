// Copies the text of an element. Where the browser does not permit that, it selects the text, to be copied by hand.
async function copyText(button, element) {
  const label = button.dataset.label ??= button.textContent;
  try {
    await navigator.clipboard.writeText(element.textContent);
    button.textContent = "Copied";
  } catch {
    getSelection().selectAllChildren(element);
    button.textContent = "Selected: press Ctrl+C";
  }
  setTimeout(() => { button.textContent = label; }, 2500);
}

// Buttons that copy the text next to them need this script, so it shows them.
for (const button of document.querySelectorAll("[data-copy]")) {
  button.hidden = false;
  button.addEventListener("click", () => copyText(button, button.parentElement.querySelector("code")));
}
