"""How do I calibrate from a folder? A depth law from presses of known depth.

    python calibrate_folder.py press1/ press2/ --profile sensor.toml

Each folder contains images and `depth.csv`: a line `frame,depth_mm`, then a row for every image.
"""

import argparse

import fingervision


def main() -> None:
    """Fits the law, writes it into the profile and prints how well it fits."""
    parser = argparse.ArgumentParser()
    parser.add_argument("presses", nargs="+")
    parser.add_argument("--profile", required=True)
    options = parser.parse_args()

    found = fingervision.calibrate_depth(options.presses, profile=options.profile, method="origin")
    print("written:", found["written"])
    print("picture:", found["picture"])
    print(fingervision.Profile.load(options.profile))


if __name__ == "__main__":
    main()
