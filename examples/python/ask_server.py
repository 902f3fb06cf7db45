#!/usr/bin/env python3
"""Asks a server where photos were taken: ask_server.py http://localhost:8080 photo.jpg ..."""

import os
import sys

import cairn

client = cairn.Client(sys.argv[1], api_key=os.environ.get("CAIRN_API_KEY"))
for photo in sys.argv[2:]:
    try:
        result = client.localize(photo)
    except cairn.Error as error:
        sys.exit(f"{photo}: {error.code}: {error}")
    if result.geopose is None:
        print(f"{photo}: {result.reason}: {result.reason_text}")
    else:
        pose = result.geopose
        print(f"{photo}: {pose.lat_deg:.7f} {pose.lon_deg:.7f} {pose.h_m:.2f}"
              f" within {result.position_accuracy_m:.2f} m, confidence {result.confidence:.3f}")
