"""Prints where UAV 0 knows cars to be, as it learns it: pip install eclipse-zenoh shapely"""
import json, sys, shapely.geometry, zenoh

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([sys.argv[1] if sys.argv[1:] else "tcp/127.0.0.1:7447"]))
with zenoh.open(config) as session:
    subscriber = session.declare_subscriber("csat/*/view/0/targets")
    for sample in subscriber:
        for feature in json.loads(sample.payload.to_string())["features"]:
            target, shape = feature["properties"]["target"], shapely.geometry.shape(feature["geometry"])
            print(f"car {target} is in {shape.area:.1f} m² around ({shape.centroid.x:.1f}, {shape.centroid.y:.1f})", flush=True)
