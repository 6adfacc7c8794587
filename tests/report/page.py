"""The page in a browser."""

import pathlib
import shutil
import tempfile
import unittest

from support.reports import device, load, point, run
from support.settings import ROOT, SCREENS


class Page(unittest.TestCase):
    """The page in Chromium, by chromedriver."""

    @classmethod
    def setUpClass(cls):
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service

        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="turner_report_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        run(["report", ROOT / "scenes/spheres.json", ROOT / "scenes/spot.json", "--width", "96", "--max-samples", "3",
             "--repeats", "2", "-o", cls.folder])
        # Alone: nothing beside it can be what makes it work.
        alone = cls.folder / "alone"
        alone.mkdir()
        shutil.move(cls.folder / "report.html", alone / "report.html")
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        for argument in ("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                         "--window-size=1200,1600", f"--user-data-dir={cls.folder / 'profile'}"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        cls.browser = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        cls.addClassCleanup(cls.browser.quit)
        cls.address = (alone / "report.html").as_uri()

    def setUp(self):
        self.browser.get(self.address)
        self.scene = load(self.folder)["scenes"][0]
        self.section = self.find("section.scene")

    def tearDown(self):
        entries = self.browser.get_log("browser")
        self.assertEqual(entries, [], "the console is not empty")

    def find(self, selector, parent=None):
        return (parent or self.browser).find_element("css selector", selector)

    def find_all(self, selector, parent=None):
        return (parent or self.browser).find_elements("css selector", selector)

    def js(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def screenshot(self, name):
        SCREENS.mkdir(parents=True, exist_ok=True)
        self.browser.save_screenshot(str(SCREENS / f"{name}.png"))

    def show(self, element):
        self.js("arguments[0].scrollIntoView({block: 'center'})", element)

    def test_it_is_whole_and_loads_nothing(self):
        self.assertEqual(len(self.find_all("section.scene")), 2)
        loaded = self.js("return performance.getEntriesByType('resource').map(e => e.name)")
        self.assertEqual([name for name in loaded if not name.startswith("data:")], [])
        self.assertTrue(self.js("return [...document.images].every(i => i.complete && i.naturalWidth > 0)"))
        text = self.find("body").text
        for part in (self.scene["devices"][0]["name"], self.scene["devices"][0]["driver"], self.scene["findings"][0]):
            self.assertIn(part, text)
        for p in self.scene["points"]:
            self.assertIn(p["command"], text)
        self.screenshot("whole")

    def test_curves_are_drawn(self):
        charts = self.find_all("svg.chart", self.section)
        self.assertEqual(len(charts), 2)
        devices = len(self.scene["devices"])
        curves = self.find_all(".curve", charts[0])
        self.assertEqual(len(curves), 3 * devices)
        for line in curves:
            self.assertGreater(self.js("return arguments[0].getTotalLength()", line), 100)
        self.assertEqual(len({(c.get_attribute("stroke"), c.get_attribute("stroke-dasharray")) for c in curves}),
                         3 * devices)
        self.assertEqual({p.get_attribute("data-point") for p in self.find_all(".point", charts[0])},
                         {p["name"] for p in self.scene["points"]})
        self.assertEqual(len(self.find_all(".front", charts[0])), 1)
        # Where a point is drawn says its time and error: of two points the slower is to the right, the more wrong above.
        place = {}
        for element in self.find_all(".point", charts[0]):
            box = self.js("const b = arguments[0].lastElementChild.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]", element)
            place[element.get_attribute("data-point")] = box
        for a in self.scene["points"]:
            for b in self.scene["points"]:
                if a["seconds"]["median"] > 1.2 * b["seconds"]["median"]:
                    self.assertGreater(place[a["name"]][0], place[b["name"]][0])
                if a["rmse"] > 1.2 * b["rmse"]:
                    self.assertLess(place[a["name"]][1], place[b["name"]][1])

    def test_hovering_labels_a_point(self):
        from selenium.webdriver import ActionChains
        label = self.find("#label")
        self.assertFalse(label.is_displayed())
        chart = self.find("svg.chart", self.section)
        self.show(chart)
        name = f"{device(self.scene)}-sobol-3x3"
        mark = self.find(f".point[data-point='{name}']", chart)
        ActionChains(self.browser).move_to_element(mark).perform()
        self.assertTrue(label.is_displayed())
        self.assertIn("RMSE", label.text)
        self.screenshot("hover")
        ActionChains(self.browser).move_to_element(self.find("h1")).perform()
        self.assertFalse(label.is_displayed())
        # By keyboard too.
        self.js("arguments[0].focus()", mark)
        self.assertTrue(label.is_displayed())
        self.assertIn(f"{device(self.scene)}, sobol 3x3", label.text)
        self.assertIn(f"{point(self.scene, name)['rmse']:.3g}", label.text)

    def test_the_table_sorts(self):
        table = self.find("table.points", self.section)
        headers = [h.text for h in self.find_all("th", table)]
        for title, key in (("RMSE", lambda p: p["rmse"]), ("median time", lambda p: p["seconds"]["median"])):
            header = self.find_all("th", table)[headers.index(title)]
            self.show(header)
            expected = sorted(key(p) for p in self.scene["points"])
            for order in (expected, expected[::-1]):
                self.find("button", header).click()
                rows = self.js("return [...arguments[0].tBodies[0].rows].map(r => r.dataset.point)", table)
                self.assertEqual([key(point(self.scene, name)) for name in rows], order)
            self.assertEqual(header.get_attribute("aria-sort"), "descending")
        self.screenshot("sorted")
        # By words.
        self.find("button", self.find_all("th", table)[0]).click()
        rows = self.js("return [...arguments[0].tBodies[0].rows].map(r => r.cells[0].textContent)", table)
        self.assertEqual(len(rows), len(self.scene["points"]))
        self.assertLess(rows.index(f"{device(self.scene)}, grid 1x1"), rows.index("reference, grid 1x1"))

    def test_the_slider_divides_the_pictures(self):
        from selenium.webdriver import ActionChains
        compare = self.find(".compare", self.section)
        self.show(compare)
        right, slider = self.find("img.right", compare), self.find("input", compare)
        clip = lambda: self.js("return getComputedStyle(arguments[0]).clipPath", right)
        self.assertIn("50%", clip())
        width = compare.size["width"]
        ActionChains(self.browser).move_to_element(slider).click_and_hold().move_by_offset(int(width * 0.3), 0).release().perform()
        dragged = float(clip().rstrip(")").split()[-1].rstrip("%"))
        self.assertAlmostEqual(dragged, 80, delta=4)
        from selenium.webdriver.common.keys import Keys
        slider.send_keys(Keys.HOME)
        self.assertIn(" 0%", clip())
        self.screenshot("slider")

        # Another point, another pair of pictures.
        from selenium.webdriver.support.ui import Select
        left = self.find("img.left", compare)
        before = left.get_attribute("src"), right.get_attribute("src")
        which = Select(self.find("select.which", self.section))
        which.select_by_index(len(which.options) - 1)
        self.assertNotEqual(before, (left.get_attribute("src"), right.get_attribute("src")))
        Select(self.find("select.other", self.section)).select_by_value("converged")
        pictures = self.js("return JSON.parse(arguments[0].querySelector('script.pictures').textContent)", self.section)
        self.assertEqual(right.get_attribute("src"), pictures["converged"])

    def test_a_chosen_row_is_marked_in_the_charts(self):
        row = self.find("table.points tbody tr", self.section)
        self.show(row)
        self.find("td", row).click()
        name = row.get_attribute("data-point")
        self.assertEqual({e.get_attribute("data-point") for e in self.find_all(".chosen", self.section)}, {name})
        self.assertGreaterEqual(len(self.find_all(".point.chosen", self.section)), 1)

    def test_it_says_all_without_scripts(self):
        # The charts have titles, the pictures are there, the tables are full: in the source, before any script ran.
        source = (self.folder / "alone/report.html").read_text()
        body = source[:source.rindex("<script>")]
        self.assertEqual(body.count("<title>"), 1 + sum(body.count(c) for c in ("class='chart'", "class='point'")))
        self.assertIn("<img class='left'", body)
        self.assertIn("<td data-value=", body)
