# Judges every claim and leaves the page: docker build -t softbody . && docker run -v "$PWD/report:/softbody/build/report" softbody
FROM python:3.11-slim
RUN apt-get -qq update && apt-get -qq -y --no-install-recommends install make git && rm -rf /var/lib/apt/lists/*
WORKDIR /softbody
COPY requirements.lock Makefile ./
RUN make .venv/ready
COPY . .
CMD ["make", "report"]
