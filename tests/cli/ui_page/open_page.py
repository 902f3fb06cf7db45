#!/usr/bin/python3
"""Opens the page /ui in headless Chromium and asks it as a person does.

open_page.py ASK.json reads {"url", "key", "screenshot", "visits": [{"photo", "lat", "lon", "accuracy", "focal", "exif"}]}, all
but the photo optional, fills in the form for each visit, presses the button, and prints one line of JSON:
{"answers": [text under the photo, ...], "console": [what Chromium's console got], "status": text at the top,
"before": text at the top before the API key was typed, "exif": [what the page reads in each of the files "exif", ...]}.
A key is typed into the field that the page shows for it.
"""
import base64
import json
import sys

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

TIMEOUT_S = 60
FIELDS = ("lat", "lon", "accuracy", "focal")


def open_browser():
    options = Options()
    options.binary_location = "/usr/bin/chromium"
    # Containers have neither a sandbox for root nor a large /dev/shm.
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu",
                     "--window-size=1280,1400"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)


def fill_in(browser, visit):
    for name in FIELDS:
        browser.find_element(By.NAME, name).clear()
    for name in FIELDS:
        if visit.get(name) is not None:
            browser.find_element(By.NAME, name).send_keys(str(visit[name]))
    checkbox = browser.find_element(By.NAME, "exif")
    if checkbox.is_selected() != visit.get("exif", True):
        checkbox.click()
    browser.find_element(By.NAME, "photo").send_keys(visit["photo"])


def is_answered(browser):
    """True once the page has put an answer, or a reason why there is none, into words."""
    output = browser.find_element(By.ID, "answer")
    button = browser.find_element(By.CSS_SELECTOR, "#form button")
    return output.is_displayed() and button.is_enabled() and output.text not in ("", "…")


def ask(browser, visit):
    browser.execute_script("document.getElementById('answer').textContent = ''")
    fill_in(browser, visit)
    browser.find_element(By.CSS_SELECTOR, "#form button").click()
    WebDriverWait(browser, TIMEOUT_S).until(is_answered)
    return browser.find_element(By.ID, "answer").text


def status_of(browser):
    return browser.find_element(By.ID, "status").text


def type_key(browser, key):
    field = browser.find_element(By.NAME, "key")
    field.send_keys(key)
    browser.find_element(By.CSS_SELECTOR, "#key-form button").click()
    WebDriverWait(browser, TIMEOUT_S).until(lambda b: status_of(b).startswith("running"))


def read_exif(browser, path):
    with open(path, "rb") as file:
        text = base64.b64encode(file.read()).decode()
    return browser.execute_script(
        "return readExif(Uint8Array.from(atob(arguments[0]), (c) => c.charCodeAt(0)).buffer)", text)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        todo = json.load(file)
    browser = open_browser()
    try:
        browser.get(todo["url"] + "/ui")
        WebDriverWait(browser, TIMEOUT_S).until(lambda b: not status_of(b).startswith("connecting"))
        before = status_of(browser)
        if todo.get("key"):
            type_key(browser, todo["key"])
        answers = [ask(browser, visit) for visit in todo.get("visits", [])]
        if todo.get("screenshot"):
            browser.save_screenshot(todo["screenshot"])
        print(json.dumps({
            "answers": answers,
            "console": [entry["message"] for entry in browser.get_log("browser")],
            "status": status_of(browser),
            "before": before,
            "exif": [read_exif(browser, path) for path in todo.get("exif", [])],
        }))
    finally:
        browser.quit()


main()
