// Without this script the page shows everything but labels on hover, other orders of the tables and other pictures.
'use strict';

const label = document.getElementById('label');

function showLabel(point) {
  label.textContent = point.dataset.label;
  label.hidden = false;
  const box = point.getBoundingClientRect();
  const left = box.left + window.scrollX + 14;
  label.style.top = `${box.bottom + window.scrollY + 8}px`;
  label.style.left = `${Math.max(4, Math.min(left, window.scrollX + document.documentElement.clientWidth - label.offsetWidth - 8))}px`;
}

// A point is chosen in a chart, in the table or in the list of pictures: all three follow.
function choose(scene, name) {
  for (const element of scene.querySelectorAll('[data-point]'))
    element.classList.toggle('chosen', element.dataset.point === name);
  const list = scene.querySelector('select.which');
  if (list && [...list.options].some(option => option.value === name)) {
    list.value = name;
    showPictures(scene);
  }
}

function showPictures(scene) {
  const pictures = JSON.parse(scene.querySelector('script.pictures').textContent);
  const point = pictures.points[scene.querySelector('select.which').value];
  const other = scene.querySelector('select.other').value;
  scene.querySelector('img.left').src = point.picture;
  scene.querySelector('img.right').src = other === 'converged' ? pictures.converged : point.error;
}

function sortBy(header) {
  const table = header.closest('table'), body = table.tBodies[0];
  const column = [...header.parentNode.children].indexOf(header);
  const ascending = header.getAttribute('aria-sort') !== 'ascending';
  for (const other of header.parentNode.children) other.removeAttribute('aria-sort');
  header.setAttribute('aria-sort', ascending ? 'ascending' : 'descending');
  const key = row => {
    const {dataset, textContent} = row.cells[column];
    return dataset.value === undefined ? textContent : dataset.value === '' ? NaN : Number(dataset.value);
  };
  const compare = (a, b) => typeof a === 'number' ? a - b : a.localeCompare(b, undefined, {numeric: true});
  const rows = [...body.rows].map(row => [key(row), row]);
  const numbers = rows.filter(([value]) => !Number.isNaN(value)), others = rows.filter(([value]) => Number.isNaN(value));
  numbers.sort(([a], [b]) => (ascending ? 1 : -1) * compare(a, b));
  body.append(...[...numbers, ...others].map(([, row]) => row));  // what is no number stands last
}

for (const point of document.querySelectorAll('.point')) {
  point.querySelector('title')?.remove();  // the browser's own label would cover ours
  point.setAttribute('aria-label', point.dataset.label);
  for (const event of ['pointerenter', 'focus']) point.addEventListener(event, () => showLabel(point));
  for (const event of ['pointerleave', 'blur']) point.addEventListener(event, () => { label.hidden = true; });
}
for (const scene of document.querySelectorAll('section.scene')) {
  scene.addEventListener('click', event => {
    const target = event.target.closest('[data-point]');
    if (target) choose(scene, target.dataset.point);
    const header = event.target.closest('th');
    if (header) sortBy(header);
  });
  const slider = scene.querySelector('.compare input');
  slider?.addEventListener('input', () => slider.parentNode.style.setProperty('--at', `${slider.value}%`));
  for (const list of scene.querySelectorAll('select')) list.addEventListener('change', () => {
    if (list.classList.contains('which')) choose(scene, list.value);
    else showPictures(scene);
  });
}
