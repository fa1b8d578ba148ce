// Lays two levels over each other with a curtain between them. The page reads without it: the viewers stay hidden then.
for (const viewer of document.querySelectorAll('.viewer')) {
  const sheets = document.querySelectorAll(`[data-sheet^="${viewer.dataset.of}-"]`);
  const part = (name) => viewer.querySelector(`[data-part="${name}"]`);
  const [left, right, pose, row, cut] = ['left', 'right', 'pose', 'row', 'cut'].map(part);
  const stage = part('stage');
  const find = (level) =>
    sheets[pose.value].querySelector(`img[data-row="${row.value}"][data-level="${level}"]`);
  const show = () => {
    for (const [side, choice] of [['a', left], ['b', right]]) {
      const from = find(choice.value);
      const image = part(`image-${side}`);
      image.src = from.src;
      image.alt = from.alt;
      part(`name-${side}`).textContent = choice.selectedOptions[0].textContent.split(' · ')[0];
      stage.style.aspectRatio = `${from.getAttribute('width')} / ${from.getAttribute('height')}`;
    }
  };
  const slide = () => stage.style.setProperty('--cut', `${cut.value}%`);
  [left, right, pose, row].forEach((choice) => choice.addEventListener('change', show));
  cut.addEventListener('input', slide);
  const drag = (event) => {
    if (event.buttons !== 1) return;
    const box = stage.getBoundingClientRect();
    cut.value = ((event.clientX - box.left) / box.width) * 100;
    slide();
    event.preventDefault();
  };
  stage.addEventListener('pointerdown', drag);
  stage.addEventListener('pointermove', drag);
  for (const [place, sheet] of sheets.entries()) {
    for (const image of sheet.querySelectorAll('img[data-level]')) {
      image.classList.add('choosable');
      image.title = 'Show this one in the viewer above';
      image.addEventListener('click', () => {
        pose.value = place;
        row.value = image.dataset.row;
        right.value = image.dataset.level;
        show();
        viewer.scrollIntoView({ behavior: 'smooth', block: 'nearest' });
      });
    }
  }
  viewer.hidden = false;
  show();
  slide();
}
